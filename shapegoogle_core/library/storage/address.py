# SPDX-License-Identifier: MIT
"""Addresses of libraries: the path of a file, or the URL of a database or a service."""

from __future__ import annotations

import os
import re
from pathlib import Path
from urllib.parse import parse_qsl, quote, unquote, urlencode, urlsplit

from shapegoogle_core.api.arguments import as_path, path_text

__all__ = [
    "Place",
    "as_place",
    "database_url",
    "is_database",
    "is_service",
    "shown_place",
    "split_password",
    "with_password",
    "without_passwords",
]

Place = Path | str
"""Path of a library file, or URL of a database or a service."""

_SCHEMES = ("postgresql://", "postgres://")
_SERVICES = ("https://", "http://")
_ADDRESS = re.compile(r"postgres(?:ql)?://.*", re.DOTALL | re.IGNORECASE)
# Options of an address that are shown; others may be secret.
_SHOWN = ("service", "host", "port", "schema")


def is_database(place: str | os.PathLike[str]) -> bool:
    """Whether a library lies in a database.

    Parameters
    ----------
    place : str or path-like

    Returns
    -------
    database : bool

    Examples
    --------
    >>> from shapegoogle_core.library.storage.address import is_database
    >>> is_database("postgresql://server/shapes"), is_database("shapes.sglib")
    (True, False)
    """
    return isinstance(place, str) and place.lower().startswith(_SCHEMES)


def is_service(place: str | os.PathLike[str]) -> bool:
    """Whether a library lies behind a service, see `shapegoogle_core.ServiceLibrary`.

    Parameters
    ----------
    place : str or path-like

    Returns
    -------
    service : bool

    Examples
    --------
    >>> from shapegoogle_core.library.storage.address import is_service
    >>> is_service("https://shapes.example"), is_service("shapes.sglib")
    (True, False)
    """
    return isinstance(place, str) and place.lower().startswith(_SERVICES)


def as_place(place: str | os.PathLike[str]) -> Place:
    """Convert to the place of a library: a path unless it is the URL of a database or a service.

    Parameters
    ----------
    place : str or path-like

    Returns
    -------
    place : Path or str

    Raises
    ------
    ValueError
        If it is neither a str nor a path.
    """
    return path_text(place) if is_database(place) or is_service(place) else as_path(place)


def shown_place(place: str | os.PathLike[str]) -> str:
    """Return the place of a library as messages name it: the address of a database without its password.

    Parameters
    ----------
    place : str or path-like

    Returns
    -------
    shown : str

    Examples
    --------
    >>> from shapegoogle_core.library.storage.address import shown_place
    >>> shown_place("postgresql://ana:secret@server/shapes?sslmode=require&schema=props")
    'postgresql://ana@server/shapes?schema=props'
    """
    if not is_database(place):
        return os.fspath(place)
    try:
        parts = urlsplit(path_text(place))
        options = [(key, value) for key, value in parse_qsl(parts.query) if key in _SHOWN]
    except ValueError:
        return f"{_SCHEMES[0]}…"
    return database_url(_without_password(parts.netloc)[0], parts.path, options)


def split_password(place: str) -> tuple[str, str]:
    """Split the address of a database into what may be shown and kept anywhere, and the password in it.

    Parameters
    ----------
    place : str

    Returns
    -------
    place, password : str
        The password is empty, and the address as it was, if it has none or cannot be understood.

    Examples
    --------
    >>> from shapegoogle_core.library.storage.address import split_password
    >>> split_password("postgresql://ana:se%40cret@server/shapes?schema=props")
    ('postgresql://ana@server/shapes?schema=props', 'se@cret')
    """
    try:
        parts = urlsplit(place)
        options = parse_qsl(parts.query, keep_blank_values=True)
    except ValueError:
        return place, ""
    server, password = _without_password(parts.netloc)
    password = unquote(password) or dict(options).get("password", "")
    if not is_database(place) or not password:
        return place, ""
    others = [(key, value) for key, value in options if key != "password"]
    return database_url(server, parts.path, others), password


def _without_password(server: str) -> tuple[str, str]:
    """Split ``user:password@server`` into ``user@server`` and the password as it is written."""
    who, at, server = server.rpartition("@")
    user, _, password = who.partition(":")
    return f"{user}{at if user else ''}{server}", password


def database_url(server: str, path: str, options: list[tuple[str, str]]) -> str:
    """Put the URL of a database together; `urllib.parse.urlunsplit` loses the slashes before an empty server.

    Parameters
    ----------
    server : str
        Such as ``ana@server:5432``; may be empty.
    path : str
        Such as ``/shapes``; may be empty.
    options : list of (str, str)

    Returns
    -------
    url : str

    Examples
    --------
    >>> from shapegoogle_core.library.storage.address import database_url
    >>> database_url("", "/shapes", [("host", "/tmp")])
    'postgresql:///shapes?host=/tmp'
    """
    url = f"{_SCHEMES[0]}{server}{path}"
    return f"{url}?{urlencode(options, quote_via=quote, safe='/')}" if options else url


def with_password(place: str, password: str) -> str:
    """Return the address of a database with a password, unless it has one.

    Parameters
    ----------
    place, password : str

    Returns
    -------
    place : str

    Examples
    --------
    >>> from shapegoogle_core.library.storage.address import with_password
    >>> with_password("postgresql://ana@server/shapes?schema=props", "se&cret")
    'postgresql://ana@server/shapes?schema=props&password=se%26cret'
    """
    if not password or split_password(place)[1]:
        return place
    return f"{place}{'&' if '?' in place else '?'}password={quote(password, safe='')}"


def without_passwords(argument: str) -> str:
    """Return an argument of a command as a log may have it.

    Parameters
    ----------
    argument : str
        Such as ``--library=postgresql://ana:secret@server/shapes``.

    Returns
    -------
    argument : str
    """
    return _ADDRESS.sub(lambda match: shown_place(match[0]), argument)
