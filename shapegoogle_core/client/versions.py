# SPDX-License-Identifier: MIT
"""The version of the interface between services and their clients."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from shapegoogle_core import __version__
from shapegoogle_core.client.address import ServiceAddress
from shapegoogle_core.client.values import text
from shapegoogle_core.errors import LibraryError

__all__ = ["API_VERSION", "check_versions"]

API_VERSION = 1
"""Version of the interface; it grows when something that a client uses changes its meaning or goes."""


def check_versions(address: ServiceAddress, info: Mapping[str, Any]) -> None:
    """Refuse a service with another version of the interface.

    Parameters
    ----------
    address : ServiceAddress
    info : mapping
        What the service says of itself.

    Raises
    ------
    LibraryError
        The sentence says which side to update.
    """
    theirs, own = int(info["api"]), __version__
    version = text(info["version"])[:40]
    if theirs > API_VERSION:
        raise LibraryError(
            f"'{address}' runs Shape Google {version}, which this version {own} is too old for; "
            "update Shape Google on this computer"
        )
    if theirs < API_VERSION:
        raise LibraryError(
            f"'{address}' runs Shape Google {version}, which is too old for this version {own}; "
            "ask whoever runs the service to update it"
        )
