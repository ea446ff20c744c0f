# SPDX-License-Identifier: MIT
"""Errors of PostgreSQL as sentences that a user can act on."""

from __future__ import annotations

import psycopg

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.store import damaged

__all__ = ["database_error", "unreachable"]

_SAFE = "everything added before is safe"
_LOST = f"lost its connection; check the network and the server, and run the same again ({_SAFE})"
_IN_USE = (
    "is in use by another program that is writing to it (waited {timeout:g} s); "
    "try again when it has finished"
)
_DENIED = (
    "can be searched, not changed, by your role; open it as a writer, or let its owner run "
    "`shapegoogle database --writer ROLE`"
)
_FULL = f"cannot grow: the disk of the server is full; make room and run the same again ({_SAFE})"
_VALUE = "cannot store this value; give names as text and sizes as numbers"
_RESOURCES = f"refused: the server is out of memory or connections; try again later ({_SAFE})"
_CHANGED = f"was changed by another program at the same time; run the same again ({_SAFE})"
# Tables or columns that are missing, and what PostgreSQL itself calls corrupted.
_DAMAGED = ("42P01", "42703", "XX001", "XX002")
# By SQLSTATE, or its class (two characters); each sentence goes on after the name of the library.
_SENTENCES = {
    "55P03": _IN_USE,
    "25006": _DENIED,
    "42501": _DENIED,
    "53100": _FULL,
    "57014": f"was stopped by a time limit of the server; raise statement_timeout ({_SAFE})",
    "08": _LOST,
    "57P": _LOST,
    "53": _RESOURCES,
    "22": _VALUE,
    # Columns that must not be empty, and numbers that must be numbers; else a row that another one refers to.
    "23502": _VALUE,
    "23514": _VALUE,
    "23": _CHANGED,
    "58": f"cannot be read or written: the disk of the server refused ({_SAFE})",
    "40": _CHANGED,
}


def database_error(error: psycopg.Error, library: str, timeout: float, *, lost: bool) -> LibraryError:
    """Make the error that says what an error of PostgreSQL means for a library and what to do.

    Parameters
    ----------
    error : psycopg.Error
    library : str
        Name of the library.
    timeout : float
        Longest time to wait for a lock, in seconds.
    lost : bool
        Whether the connection is broken.

    Returns
    -------
    error : LibraryError
    """
    if lost:
        return LibraryError(f"'{library}' {_LOST}")
    # Without a state the client has refused a value, before it asked the server.
    state = error.sqlstate or "22"
    if state in _DAMAGED:
        return damaged(library, "its tables contradict each other")
    for length in (5, 3, 2):
        if sentence := _SENTENCES.get(state[:length]):
            return LibraryError(f"'{library}' " + sentence.format(timeout=timeout))
    said = error.diag.message_primary or "no reason"
    return LibraryError(f"'{library}' could not do this; PostgreSQL says: {said} ({_SAFE})")


def unreachable(error: psycopg.Error, library: str) -> LibraryError:
    """Make the error for a database that cannot be connected to.

    Parameters
    ----------
    error : psycopg.Error
        From connecting; its text is that of the server and names no password.
    library : str
        Name of the library.

    Returns
    -------
    error : LibraryError
    """
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    reason = (lines[-1] if lines else "no answer").partition("FATAL: ")[
        2
    ].strip() or "no server answers there"
    return LibraryError(
        f"'{library}' cannot be opened: {reason}; check the address, that the server runs, and that it lets "
        "you in (password in ~/.pgpass or PGPASSWORD)"
    )
