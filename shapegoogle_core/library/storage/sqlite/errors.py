# SPDX-License-Identifier: MIT
"""SQLite errors as sentences that a user can act on."""

from __future__ import annotations

import os
import sqlite3
from pathlib import Path

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.errors import damaged

__all__ = ["library_error", "read_only_error"]

# An extended result code carries its primary code in the lowest byte.
_PRIMARY = 0xFF


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
    if code == sqlite3.SQLITE_READONLY_ROLLBACK:
        return LibraryError(
            f"'{path}' was interrupted while it was written and its place is read-only, so the interrupted "
            f"part cannot be undone; copy it together with '{path.name}-journal' to a folder that can be "
            "written and open it there"
        )
    match code & _PRIMARY:
        case sqlite3.SQLITE_BUSY | sqlite3.SQLITE_LOCKED:
            return LibraryError(
                f"'{path}' is in use by another program that is writing to it (waited {timeout:g} s); "
                "try again when that has finished"
            )
        case sqlite3.SQLITE_FULL:
            return LibraryError(
                f"'{path}' cannot grow: the disk is full; make room and run the same again (all that was "
                "added before is safe)"
            )
        case sqlite3.SQLITE_READONLY | sqlite3.SQLITE_PERM | sqlite3.SQLITE_AUTH:
            return read_only_error(path)
        case sqlite3.SQLITE_CANTOPEN if os.path.lexists(path):
            # The file is there: it may not be read, or the journal beside it cannot be made.
            return LibraryError(
                f"'{path}' cannot be opened: you may not read the file, or not write into its folder; "
                "change the permissions, or copy it to a folder of yours"
            )
        case sqlite3.SQLITE_CANTOPEN:
            return LibraryError(
                f"'{path}' cannot be made: its folder is read-only or not yours; choose another place"
            )
        case sqlite3.SQLITE_NOTADB:
            return LibraryError(
                f"'{path}' is not a Shape Google library (not an SQLite database); choose another file"
            )
        case sqlite3.SQLITE_CORRUPT:
            return damaged(str(path), str(error))
        case sqlite3.SQLITE_IOERR | sqlite3.SQLITE_PROTOCOL | sqlite3.SQLITE_NOLFS:
            return LibraryError(
                f"'{path}' cannot be read or written ({_name(error)}): the disk, its quota or the network "
                "drive refused; make room or copy the library to a local disk (all that was added before is "
                "safe)"
            )
        case sqlite3.SQLITE_TOOBIG:
            return LibraryError(
                f"'{path}' cannot take it: a name, picture or bag is over a gigabyte; leave it out"
            )
        case _:
            return damaged(str(path), f"{_name(error)}: {error}")


def read_only_error(path: Path) -> LibraryError:
    """Make the error for a change of a library that is read-only.

    Parameters
    ----------
    path : Path
        The library.

    Returns
    -------
    error : LibraryError
    """
    return LibraryError(
        f"'{path}' or its folder is read-only: it can be searched, not changed; copy it to a place that can "
        "be written to add or remove shapes"
    )


def _misuse(error: sqlite3.Error, path: Path) -> LibraryError:
    """Errors of Python's own sqlite3 module carry no code: a closed connection, or another thread's."""
    if "closed" in str(error):
        return LibraryError(f"'{path}' was closed; open it again with Library.open")
    if "thread" in str(error):
        return LibraryError(f"'{path}' was opened in another thread; open the library again in each thread")
    return LibraryError(f"'{path}' cannot take this value ({error})")


def _name(error: sqlite3.Error) -> str:
    return getattr(error, "sqlite_errorname", type(error).__name__)
