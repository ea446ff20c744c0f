# SPDX-License-Identifier: MIT
"""SQLite errors as sentences that a user can act on."""

from __future__ import annotations

import os
import sqlite3
from pathlib import Path

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.store import damaged

__all__ = ["library_error", "read_only_error"]

_IN_USE = (
    "'{path}' is in use by another program that is writing to it (waited {timeout:g} s); "
    "try again when it has finished"
)
_READ_ONLY = (
    "'{path}' or its folder is read-only: it can be searched, not changed; copy it to a place that can be "
    "written to add or remove shapes"
)
_REFUSED = (
    "'{path}' cannot be read or written: the disk, its quota or the network drive refused; make room or "
    "copy the library to a local disk (everything added before is safe)"
)
# The file is there: it may not be read, or the journal beside it cannot be created.
_NOT_OPENED = (
    "'{path}' cannot be opened: you may not read the file, or not write into its folder; change the "
    "permissions, or copy it to a folder of yours"
)
# By primary or extended result code.
_SENTENCES = {
    sqlite3.SQLITE_BUSY: _IN_USE,
    sqlite3.SQLITE_LOCKED: _IN_USE,
    sqlite3.SQLITE_FULL: (
        "'{path}' cannot grow: the disk is full; make room and run the same again (everything added before "
        "is safe)"
    ),
    sqlite3.SQLITE_READONLY: _READ_ONLY,
    sqlite3.SQLITE_PERM: _READ_ONLY,
    sqlite3.SQLITE_AUTH: _READ_ONLY,
    sqlite3.SQLITE_READONLY_ROLLBACK: (
        "'{path}' was interrupted while it was written and its place is read-only, so the interrupted part "
        "cannot be undone; copy it together with '{file}-journal' to a folder that can be written and "
        "open it there"
    ),
    sqlite3.SQLITE_CANTOPEN: (
        "'{path}' cannot be created: its folder is read-only or not yours; choose another place"
    ),
    sqlite3.SQLITE_NOTADB: (
        "'{path}' is not a Shape Google library (not an SQLite database); choose another file"
    ),
    sqlite3.SQLITE_IOERR: _REFUSED,
    sqlite3.SQLITE_PROTOCOL: _REFUSED,
    sqlite3.SQLITE_NOLFS: _REFUSED,
    sqlite3.SQLITE_NOMEM: (
        "'{path}' cannot be used: there is not enough memory; close other programs and try again (everything "
        "added before is safe)"
    ),
    sqlite3.SQLITE_TOOBIG: "'{path}' cannot store a name, picture or bag of over a gigabyte; leave it out",
}


def library_error(error: sqlite3.Error, path: Path, timeout: float) -> LibraryError:
    """Make the error that says what an SQLite error means for a library and what to do.

    Parameters
    ----------
    error : sqlite3.Error
    path : Path
        The library.
    timeout : float
        Longest time to wait for a lock, in seconds.

    Returns
    -------
    error : LibraryError
    """
    code = getattr(error, "sqlite_errorcode", None)
    if code is None:
        return _misuse(error, path)
    primary = code & 0xFF  # an extended result code carries its primary code in the lowest byte
    if primary == sqlite3.SQLITE_CANTOPEN and os.path.lexists(path):
        return LibraryError(_NOT_OPENED, path=path)
    sentence = _SENTENCES.get(code) or _SENTENCES.get(primary)
    if sentence is None:
        return damaged(str(path), "its tables contradict each other")
    return LibraryError(sentence, path=path, timeout=timeout, file=path.name)


def read_only_error(path: Path, *, requested: bool) -> LibraryError:
    """Make the error for a change of a library that is read-only.

    Parameters
    ----------
    path : Path
        The library.
    requested : bool
        Whether the library was opened with ``read_only=True``.

    Returns
    -------
    error : LibraryError
    """
    if requested:
        return LibraryError(
            f"'{path}' was opened with read_only=True; open it without to add or remove shapes"
        )
    return LibraryError(_READ_ONLY, path=path)


def _misuse(error: sqlite3.Error, path: Path) -> LibraryError:
    """Errors of Python's own sqlite3 module carry no code: a closed connection, or another thread's."""
    if "closed" in str(error):
        return LibraryError(f"'{path}' was closed; open it again with Library.open")
    if "thread" in str(error):
        return LibraryError(f"'{path}' was opened in another thread; open the library again in each thread")
    return LibraryError(f"'{path}' cannot store this value; give names as text and sizes as numbers")
