# SPDX-License-Identifier: MIT
"""An SQLite file: connection, transactions, and errors of sqlite3 as `LibraryError`.

A library uses a rollback journal (``journal_mode=DELETE``, ``synchronous=FULL``) and not a write-ahead log.
With such a log readers could go on while a writer commits, but it needs shared memory: it does not work on a
network drive, a read-only folder cannot hold its two extra files, and a copy of the library alone lacks the
newest shapes. A library is a file that people copy, put on a network drive and burn on a disc. With a
rollback journal it is one file whenever nobody writes, and after kill -9 or a power cut whoever opens it next
undoes the interrupted transaction. In return a commit waits for running reads, and reads wait for the commit;
both take milliseconds, because no method leaves a read open.

A library that is only read is still opened for writing where that is allowed (``query_only`` then forbids
changes), because undoing the transaction of a killed writer is writing.
"""

from __future__ import annotations

import os
import sqlite3
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.local_folders import LocalFolders
from shapegoogle_core.library.storage.sqlite.errors import library_error, read_only_error
from shapegoogle_core.library.storage.store import damaged

__all__ = ["Database", "encoded"]

# In seconds. A commit shuts readers out, and SQLite lets them try again only every 100 ms, so commits in a
# row would starve them (see docs/reference/library.md). A writer therefore pauses as long as its last change
# took. One that describes shapes in between never waits.
LONGEST_PAUSE = 0.1
# SQLite before 3.32 takes at most 999 parameters in one statement.
IDS_AT_ONCE = 500


class Database:
    """An open SQLite file. Errors of sqlite3 become `LibraryError`.

    Parameters
    ----------
    path : Path
        The file.
    create : bool
        Make an empty file if there is none.
    read_only : bool
        Refuse changes.
    timeout : float
        Longest time to wait for another program's lock, in seconds.

    Attributes
    ----------
    name : str
        The path, as error messages name the library.
    read_only : bool
        Whether changes are refused: on request, or because the file is write-protected.
    """

    def __init__(self, path: Path, *, create: bool, read_only: bool, timeout: float) -> None:
        self.path = path
        self.name = str(path)
        self.timeout = timeout
        self.local_folders = LocalFolders()
        self._next_write = 0.0
        with self.explained():
            self.connection = sqlite3.connect(
                _uri(path, "rwc" if create else "rw"), uri=True, timeout=timeout, isolation_level=None
            )
        self.read_only = read_only or not os.access(path, os.W_OK)
        self.connection.text_factory = _decoded
        try:
            with self.explained():
                self.connection.execute("PRAGMA foreign_keys = ON")
                self.connection.execute("PRAGMA synchronous = FULL")
                self.connection.execute(f"PRAGMA query_only = {int(read_only)}")
        except BaseException:
            self.connection.close()
            raise

    def close(self) -> None:
        """Close the file. Closing twice does no harm."""
        with self.explained():
            self.connection.close()

    @contextmanager
    def snapshot(self) -> Iterator[None]:
        """Let all reads inside see the file at one moment; writers wait meanwhile, so be quick."""
        with self.explained(), self._transaction("BEGIN"):
            yield

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Run the changes inside as one transaction: all of them are stored, or none."""
        if self.read_only:
            raise read_only_error(self.path, requested=os.access(self.path, os.W_OK))
        time.sleep(max(0.0, self._next_write - time.monotonic()))
        started = time.monotonic()
        # IMMEDIATE takes the writer's lock at once; two that want it after reading would block each other.
        with self.explained(), self._transaction("BEGIN IMMEDIATE"):
            yield
        ended = time.monotonic()
        self._next_write = ended + min(ended - started, LONGEST_PAUSE)

    def copy_file(self, path: Path) -> None:
        """Write a copy of the file as it is now; the new one must not exist."""
        if path.exists():
            raise LibraryError(f"'{path}' exists already; move it away, or choose another name for the copy")
        copy = Database(path, create=True, read_only=False, timeout=self.timeout)
        try:
            with self.explained():
                self.connection.backup(copy.connection)
        except BaseException:
            # Half a copy would look like a backup, and be in the way of the next one.
            copy.close()
            path.unlink(missing_ok=True)
            raise
        copy.close()

    @contextmanager
    def explained(self) -> Iterator[None]:
        """Turn errors of sqlite3 into `LibraryError`."""
        try:
            yield
        except sqlite3.Error as error:
            raise library_error(error, self.path, self.timeout) from error
        except UnicodeDecodeError as error:
            raise self.damaged("a name is not valid text") from error

    def damaged(self, detail: str) -> LibraryError:
        """Make the error for content that contradicts itself."""
        return damaged(self.name, detail)

    def rows(self, statement: str, *parameters: object) -> list[tuple[Any, ...]]:
        """Run a query and return all rows."""
        with self.explained():
            return self.connection.execute(statement, parameters).fetchall()

    def rows_with_ids(self, statement: str, ids: Sequence[int]) -> list[tuple[Any, ...]]:
        """Run a query that ends with the column of ids, for these ids; rows come in the order of ids."""
        rows = []
        ordered = sorted(ids)
        for start in range(0, len(ordered), IDS_AT_ONCE):
            portion = ordered[start : start + IDS_AT_ONCE]
            marks = ", ".join("?" * len(portion))
            rows += self.rows(f"{statement} IN ({marks}) ORDER BY 1", *portion)
        return rows

    def value(self, statement: str, *parameters: object) -> Any:
        """Run a query and return its first value, None if there is none."""
        rows = self.rows(statement, *parameters)
        return rows[0][0] if rows else None

    def execute(self, statement: str, *parameters: object) -> int:
        """Run a change, inside `writing`; return how many rows it met."""
        return self.connection.execute(statement, parameters).rowcount

    def matrix(self, blobs: Sequence[bytes], dtype: np.dtype[Any], width: int) -> NDArray[Any]:
        """Stack the contents of rows into an array (n, width); `LibraryError` if their lengths do not fit."""
        if any(len(blob) != width * dtype.itemsize for blob in blobs):
            raise self.damaged("a bag or code has another length than its model's")
        return np.frombuffer(b"".join(blobs), dtype).reshape(len(blobs), width)

    @contextmanager
    def _transaction(self, begin: str) -> Iterator[None]:
        try:
            self.connection.execute(begin)
            yield
            self.connection.execute("COMMIT")
        except BaseException:  # Ctrl-C as well: no transaction may stay open
            if self.connection.in_transaction:
                self.connection.execute("ROLLBACK")
            raise


def _uri(path: Path, mode: str) -> str:
    """Make the ``file:`` URI of a path; Windows drives and network shares included.

    `Path.as_uri` puts a share's host where SQLite refuses it: it wants an empty host, then the whole
    path.
    """
    absolute = path.absolute().as_posix()
    return f"file://{'' if absolute.startswith('/') else '/'}{quote(os.fsencode(absolute))}?mode={mode}"


def encoded(text: str) -> bytes:
    """Encode a name. File names need not be valid Unicode; sqlite3 takes such names only as bytes.

    Parameters
    ----------
    text : str

    Returns
    -------
    content : bytes
        For ``CAST(? AS TEXT)``.
    """
    return text.encode("utf-8", "surrogatepass")


def _decoded(content: bytes) -> str:
    return content.decode("utf-8", "surrogatepass")
