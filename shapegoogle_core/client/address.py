# SPDX-License-Identifier: MIT
"""`ServiceAddress`: the address of a service, checked before anything is sent there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self
from urllib.parse import quote, urlsplit

from shapegoogle_core.api.hosts import is_loopback
from shapegoogle_core.errors import LibraryError

__all__ = ["ServiceAddress"]


@dataclass(frozen=True)
class ServiceAddress:
    """The address of a service.

    Attributes
    ----------
    host : str
    port : int
    is_encrypted : bool
        Whether it is HTTPS. Without it only services of this machine are asked: everybody on the way could
        read the token.
    prefix : str
        Of all paths, for a service below a path of a server; empty, or such as "/shapes".
    """

    host: str
    port: int
    is_encrypted: bool
    prefix: str = ""

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read an address.

        Parameters
        ----------
        text : str
            Such as "https://shapes.example:8443/props".

        Returns
        -------
        address : ServiceAddress

        Raises
        ------
        LibraryError
            If it cannot be the address of a service.

        Examples
        --------
        >>> from shapegoogle_core.client import ServiceAddress
        >>> str(ServiceAddress.parse("https://shapes.example/"))
        'https://shapes.example'
        """
        given = text.strip()
        try:
            parts = urlsplit(given)
            host, port = parts.hostname or "", parts.port
            host.encode("idna")  # as it is looked up; raises an error for what cannot be a name
        except ValueError:
            host, port = "", None
        if not host or not host.isprintable() or " " in host or port == 0:
            raise LibraryError(f"{_shown(given)!r} is no address of a service; it looks like https://server")
        if parts.username is not None or parts.password is not None:
            raise LibraryError(
                f"'{parts.scheme}://{host}' takes no name and password in its address; leave them out, and "
                "give the token of the service"
            )
        if parts.query or parts.fragment:
            raise LibraryError(f"{_shown(given)!r} goes on after the path; leave out what follows ? and #")
        is_encrypted = parts.scheme.lower() == "https"
        prefix = quote(parts.path.rstrip("/"), safe="/%:@!$&'()*+,;=~-._")
        address = cls(host, port or (443 if is_encrypted else 80), is_encrypted, prefix)
        if not is_encrypted and not is_loopback(host):
            raise LibraryError(
                f"'{address}' is not encrypted; use https://, or http:// with a service of this computer only"
            )
        return address

    def __str__(self) -> str:
        scheme, usual = ("https", 443) if self.is_encrypted else ("http", 80)
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{scheme}://{host}{'' if self.port == usual else f':{self.port}'}{self.prefix}"


def _shown(text: str) -> str:
    """Leave out what may be a password."""
    scheme, separator, rest = text.partition("://")
    return f"{scheme}{separator}{rest.rpartition('@')[2]}"
