# SPDX-License-Identifier: MIT
"""Every SQLite error becomes a sentence that names the library and says what to do."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.sqlite.errors import library_error


def sqlite_error(code: int) -> sqlite3.Error:
    error = sqlite3.OperationalError("as SQLite words it")
    error.sqlite_errorcode, error.sqlite_errorname = code, "SQLITE_NAME"
    return error


@pytest.mark.parametrize(
    ("code", "advice"),
    [
        (sqlite3.SQLITE_BUSY, r"waited 2\.5 s\); try again"),
        (sqlite3.SQLITE_BUSY_SNAPSHOT, "try again"),
        (sqlite3.SQLITE_FULL, "the disk is full; make room"),
        (sqlite3.SQLITE_READONLY, "copy it to a place that can be written"),
        (sqlite3.SQLITE_READONLY_DIRECTORY, "copy it to a place that can be written"),
        (sqlite3.SQLITE_READONLY_ROLLBACK, "copy it together with 'shapes.sglib-journal'"),
        (sqlite3.SQLITE_CANTOPEN, "cannot be created: .*choose another place"),
        (sqlite3.SQLITE_NOTADB, "is not a Shape Google library .*choose another file"),
        (
            sqlite3.SQLITE_CORRUPT,
            r"is damaged .*\(its tables contradict each other\); restore it from a backup",
        ),
        (sqlite3.SQLITE_IOERR_WRITE, r"cannot be read or written: .*make room or copy the library"),
        (sqlite3.SQLITE_NOMEM, "not enough memory; close other programs"),
        (sqlite3.SQLITE_TOOBIG, "over a gigabyte; leave it out"),
        (sqlite3.SQLITE_INTERNAL, r"is damaged .*contradict each other"),
    ],
)
def test_each_error_says_what_to_do(path: Path, code: int, advice: str) -> None:
    assert f"'{path}'" in str(library_error(sqlite_error(code), path, 2.5))
    with pytest.raises(LibraryError, match=advice):
        raise library_error(sqlite_error(code), path, 2.5)


def test_a_file_that_exists_but_cannot_be_opened(path: Path) -> None:
    path.touch()
    with pytest.raises(LibraryError, match=r"you may not read the file, .*change the permissions"):
        raise library_error(sqlite_error(sqlite3.SQLITE_CANTOPEN), path, 1)


def test_misuse_has_no_code(path: Path) -> None:
    with pytest.raises(LibraryError, match=r"shapes\.sglib' cannot store this value; give names as text"):
        raise library_error(sqlite3.InterfaceError("odd"), path, 1)
