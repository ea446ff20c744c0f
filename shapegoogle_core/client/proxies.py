# SPDX-License-Identifier: MIT
"""The HTTP proxy on the way to a service, as the environment or the settings of the computer name it."""

from __future__ import annotations

import base64
from dataclasses import dataclass, field
from urllib.parse import unquote, urlsplit
from urllib.request import getproxies, proxy_bypass

from shapegoogle_core.api.hosts import is_loopback
from shapegoogle_core.client.address import ServiceAddress
from shapegoogle_core.errors import LibraryError

__all__ = ["Proxy", "proxy_for"]


@dataclass(frozen=True)
class Proxy:
    """A proxy, through which an encrypted connection to a service goes: it cannot read the token.

    Attributes
    ----------
    host : str
    port : int
    headers : dict of str to str
        For the proxy itself: who may use it.
    """

    host: str
    port: int
    headers: dict[str, str] = field(default_factory=dict, repr=False)

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


def proxy_for(address: ServiceAddress) -> Proxy | None:
    """Return the proxy on the way to a service.

    Parameters
    ----------
    address : ServiceAddress

    Returns
    -------
    proxy : Proxy or None
        None without one, and always for a service of this computer and without HTTPS: a proxy could read
        what is sent.

    Raises
    ------
    LibraryError
        If the proxy is of another sort, such as SOCKS.
    """
    if not address.is_encrypted or is_loopback(address.host):
        return None
    named = getproxies().get("https", "")
    if not named or proxy_bypass(f"{address.host}:{address.port}"):
        return None
    try:
        parts = urlsplit(named if "://" in named else f"http://{named}")
        host, port = parts.hostname or "", parts.port or 80
    except ValueError:
        parts, host, port = urlsplit(""), "", 0
    if parts.scheme.lower() != "http" or not host:
        raise LibraryError(
            f"the proxy on the way to '{address}' cannot be used; it must be like http://proxy:3128 in the "
            "environment variable https_proxy, or the service be named in no_proxy"
        )
    if parts.username is None:
        return Proxy(host, port)
    login = f"{unquote(parts.username)}:{unquote(parts.password or '')}".encode()
    return Proxy(host, port, {"Proxy-Authorization": f"Basic {base64.b64encode(login).decode()}"})
