# SPDX-License-Identifier: MIT
"""Names and addresses of machines."""

from __future__ import annotations

import ipaddress

__all__ = ["is_loopback"]


def is_loopback(host: str) -> bool:
    """Whether only programs of this machine reach an address.

    Parameters
    ----------
    host : str

    Returns
    -------
    loopback : bool

    Examples
    --------
    >>> from shapegoogle_core.api.hosts import is_loopback
    >>> [is_loopback(host) for host in ("127.0.0.1", "localhost", "::1", "0.0.0.0", "studio.example")]
    [True, True, True, False, False]
    """
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
