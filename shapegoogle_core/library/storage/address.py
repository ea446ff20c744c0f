# SPDX-License-Identifier: MIT
"""Addresses of libraries: the path of a file, or the URL of a database or a service."""

from __future__ import annotations

import os
import re
from pathlib import Path
from urllib.parse import parse_qsl, quote, urlencode, urlsplit

from shapegoogle_core.api.arguments import as_path, path_text

__all__ = ["Place", "as_place", "is_database", "is_service", "shown_place", "without_passwords"]

Place = Path | str
"""Path of a library file, or URL of a database or a service."""

_SCHEMES = ("postgresql://", "postgres://")
_SERVICES = ("https://", "http://")
_ADDRESS = re.compile(r"postgres(?:ql)?://.*", re.DOTALL)
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
    return isinstance(place, str) and place.startswith(_SCHEMES)


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
    who, at, server = parts.netloc.rpartition("@")
    user = who.partition(":")[0]
    shown = f"{_SCHEMES[0]}{user}{at if user else ''}{server}{parts.path}"
    return f"{shown}?{urlencode(options, quote_via=quote, safe='/')}" if options else shown


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
