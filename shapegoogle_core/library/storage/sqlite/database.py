# SPDX-License-Identifier: MIT
"""An SQLite file: how it is opened, read in one state, changed in transactions, and how errors are told.

Why a rollback journal (``journal_mode=DELETE``, ``synchronous=FULL``) and not a write-ahead log: a log lets
readers go on while a writer commits, but it needs shared memory. It does not work on a network drive, cannot
be opened in a read-only folder without two more files beside the library, and until a checkpoint the newest
shapes lie in one of them, so that copying the library loses them. A library is a file that people copy, put
on a network drive and burn on a disc. With a rollback journal it is one file whenever nobody writes, a
read-only place needs nothing special, and after kill -9 or a power cut whoever opens it next undoes the
interrupted transaction. The price: a commit waits until the running reads are done, and reads wait for the
commit. Both take milliseconds, because no method leaves a read open: listings are read page by page.

Even for reading alone the file is opened for writing where that is allowed (``query_only`` then forbids
changes): undoing what a killed writer left behind is writing.
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

from shapegoogle_core.library.storage.sqlite.errors import damaged, library_error, read_only_error

__all__ = ["Database", "encoded"]

# In seconds. A commit shuts readers out, and SQLite lets them ask again only every 100 ms. One commit right
# after the other would starve them (for 11 s in a trial; 0.1 s with the pause), so a writer pauses for as
# long as its last change took. One that describes shapes in between never waits.
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
        Make an empty file when there is none.
    read_only : bool
        Refuse changes.
    timeout : float
        How long to wait for another program's lock, in seconds.
    """

    def __init__(self, path: Path, *, create: bool, read_only: bool, timeout: float) -> None:
        self.path = path
        self.timeout = timeout
        self._next_write = 0.0
        with self._explained():
            self._connection = sqlite3.connect(
                _uri(path, "rwc" if create else "rw"), uri=True, timeout=timeout, isolation_level=None
            )
        self.read_only = read_only or not os.access(path, os.W_OK)
        self._connection.text_factory = _decoded
        try:
            with self._explained():
                self._connection.execute("PRAGMA foreign_keys = ON")
                self._connection.execute("PRAGMA synchronous = FULL")
                self._connection.execute(f"PRAGMA query_only = {int(read_only)}")
        except BaseException:
            self._connection.close()
            raise

    def close(self) -> None:
        """Close the file; nothing is left to write."""
        with self._explained():
            self._connection.close()

    @contextmanager
    def snapshot(self) -> Iterator[None]:
        """Let all reads inside see the file at one moment; writers wait meanwhile, so be quick."""
        with self._explained(), self._transaction("BEGIN"):
            yield

    def _rows(self, statement: str, *parameters: object) -> list[tuple[Any, ...]]:
        with self._explained():
            return self._connection.execute(statement, parameters).fetchall()

    def _rows_with_ids(self, statement: str, ids: Sequence[int]) -> list[tuple[Any, ...]]:
        rows = []
        ordered = sorted(ids)
        for start in range(0, len(ordered), IDS_AT_ONCE):
            portion = ordered[start : start + IDS_AT_ONCE]
            marks = ", ".join("?" * len(portion))
            rows += self._rows(f"{statement} IN ({marks}) ORDER BY 1", *portion)
        return rows

    def _value(self, statement: str, *parameters: object) -> Any:
        rows = self._rows(statement, *parameters)
        return rows[0][0] if rows else None

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        if self.read_only:
            raise read_only_error(self.path)
        # IMMEDIATE takes the writer's lock at once; two that want it after reading would block each other.
        time.sleep(max(0.0, self._next_write - time.monotonic()))
        started = time.monotonic()
        with self._explained(), self._transaction("BEGIN IMMEDIATE"):
            yield self._connection
        ended = time.monotonic()
        self._next_write = ended + min(ended - started, LONGEST_PAUSE)

    @contextmanager
    def _transaction(self, begin: str) -> Iterator[None]:
        try:
            self._connection.execute(begin)
            yield
            self._connection.execute("COMMIT")
        except BaseException:  # Ctrl-C as well: nothing half done may stay open
            if self._connection.in_transaction:
                self._connection.execute("ROLLBACK")
            raise

    @contextmanager
    def _explained(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            raise library_error(error, self.path, self.timeout) from error
        except UnicodeDecodeError as error:
            raise damaged(self.path, "a name is no text") from error


def _uri(path: Path, mode: str) -> str:
    """``file:`` URI of a path; Windows drives and network shares included.

    `Path.as_uri` puts a share's host where SQLite refuses it: it wants an empty host, then the whole path.
    """
    absolute = path.absolute().as_posix()
    return f"file://{'' if absolute.startswith('/') else '/'}{quote(os.fsencode(absolute))}?mode={mode}"


def encoded(text: str) -> bytes:
    """Bytes of a name. File names need not be valid Unicode; sqlite3 takes such ones only as bytes."""
    return text.encode("utf-8", "surrogatepass")


def _decoded(content: bytes) -> str:
    return content.decode("utf-8", "surrogatepass")
