# SPDX-License-Identifier: MIT
"""URL of a database: what the client needs to connect, and a name without secrets for messages."""

from __future__ import annotations

from dataclasses import dataclass, field
from urllib.parse import parse_qsl, urlsplit

from psycopg import Error
from psycopg.conninfo import conninfo_to_dict

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.address import database_url, shown_place

__all__ = ["DEFAULT_SCHEMA", "DatabaseAddress", "parse_address"]

DEFAULT_SCHEMA = "shapegoogle"
"""Schema of the tables, so that a library can share a database with other programs."""

# Longest name that PostgreSQL does not cut off, in bytes.
_LONGEST_NAME = 63


@dataclass(frozen=True)
class DatabaseAddress:
    """A database and the schema in it.

    Attributes
    ----------
    name : str
        URL without password and options, as messages name the library.
    parameters : dict of str to str
        Those of libpq; it completes them from the environment (PG…), a service file and ~/.pgpass.
    schema : str
        Schema of the tables.
    """

    name: str
    parameters: dict[str, str] = field(repr=False)
    schema: str = DEFAULT_SCHEMA


def parse_address(url: str) -> DatabaseAddress:
    """Take the URL of a database apart.

    Parameters
    ----------
    url : str
        ``postgresql://user:password@host:port/name``, each part optional. ``schema`` among its options
        names the schema of the library; all others are those of libpq.

    Returns
    -------
    address : DatabaseAddress

    Raises
    ------
    LibraryError
        If it cannot be understood.
    """
    try:
        parts = urlsplit(url)
        options = parse_qsl(parts.query, keep_blank_values=True)
        schema = dict(options).get("schema", DEFAULT_SCHEMA)
        others = [(key, value) for key, value in options if key != "schema"]
        parameters = conninfo_to_dict(database_url(parts.netloc, parts.path, others))
    except (ValueError, Error):
        # Neither the URL nor the client's text is shown: both may have the password in them.
        raise LibraryError(
            "the address of the database cannot be understood; write it as postgresql://user@host:5432/name, "
            "with %40 for @ and %2F for / in names and passwords"
        ) from None
    if not 0 < len(schema.encode("utf-8", "replace")) <= _LONGEST_NAME or "\0" in schema:
        raise LibraryError(f"a schema has a name of 1 to {_LONGEST_NAME} bytes, not {schema!r}")
    return DatabaseAddress(shown_place(url), {key: str(value) for key, value in parameters.items()}, schema)
