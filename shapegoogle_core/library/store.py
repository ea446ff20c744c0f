# SPDX-License-Identifier: MIT
"""The library file: with its tables (`schema`) and packed codes (`code_blocks`) the only place with SQL.

A shared PostgreSQL library would be another class with the methods of `Store`.

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
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.code_blocks import CODE_TABLES, CodeBlocks
from shapegoogle_core.library.failures import damaged, library_error, read_only_error
from shapegoogle_core.library.records import NewShape, ShapeRecord, SourceRecord
from shapegoogle_core.library.schema import (
    APPLICATION_ID,
    BAG_TYPE,
    SCHEMA,
    SCHEMA_VERSION,
    UNREADABLE_VERSION,
)

__all__ = ["Store", "round_bags"]

SELECT_SHAPES = """
SELECT shapes.id, name, coalesce(path, ''), object_name, vertex_count, face_count, area
FROM shapes LEFT JOIN sources ON sources.id = source_id
"""

# In seconds. A commit shuts readers out, and SQLite lets them ask again only every 100 ms. One commit right
# after the other would starve them (for 11 s in a trial; 0.1 s with the pause), so a writer pauses for as
# long as its last change took. One that describes shapes in between never waits.
LONGEST_PAUSE = 0.1
# SQLite before 3.32 takes at most 999 parameters in one statement.
IDS_AT_ONCE = 500


class Store:
    """An open library file.

    Every method raises `LibraryError`, never an error of sqlite3. Every change is one transaction: all of it
    is in the file when the method returns, or nothing. Use it only in the thread that made it.

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
        self._code_blocks = {table: CodeBlocks(self._connection, table) for table in CODE_TABLES}
        # Those that lose a shape in the running transaction.
        self._losing_blocks: dict[str, set[int]] = {table: set() for table in CODE_TABLES}
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

    # -- the file as a whole --------------------------------------------------------------------------------

    def is_empty(self) -> bool:
        """Whether nothing was ever committed to the file: it is new, or its making was interrupted."""
        tables = self._value("SELECT count(*) FROM sqlite_master")
        return bool(tables == 0 and self._value("PRAGMA application_id") == 0)

    def initialise(self, model_identifier: str, model_content: bytes) -> None:
        """Make the tables and put the model in, unless another program did so in the meantime.

        Parameters
        ----------
        model_identifier : str
        model_content : bytes
            As `ShapeModel.to_bytes` returns them.
        """
        with self._writing() as connection:
            if not self.is_empty():
                return
            connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            for statement in SCHEMA.split(";\n"):
                connection.execute(statement)
            connection.execute("INSERT INTO meta VALUES ('schema', ?)", (str(SCHEMA_VERSION),))
            connection.execute("INSERT INTO model VALUES (?, ?)", (model_identifier, model_content))

    def check_format(self) -> None:
        """Make sure that this is a library, and one that this version understands.

        Raises
        ------
        LibraryError
            If the file is something else, damaged, or of a version that this one cannot read.
        """
        if self._value("PRAGMA application_id") != APPLICATION_ID:
            raise LibraryError(
                f"'{self.path}' is an SQLite database of another program, not a Shape Google library; "
                "choose another file"
            )
        version = self._value("SELECT value FROM meta WHERE key = 'schema'")
        if not isinstance(version, str) or not version.isdecimal():
            raise damaged(self.path, "it does not say which format it has")
        if int(version) > SCHEMA_VERSION:
            raise LibraryError(
                f"'{self.path}' was made by a newer version of Shape Google (format {version}, this one "
                f"knows up to {SCHEMA_VERSION}); update Shape Google, or index your folders anew"
            )
        if int(version) == UNREADABLE_VERSION:
            raise LibraryError(
                f"'{self.path}' has format {version}, which was in use for a short time and can no longer be "
                "read; index your folders into a new library"
            )

    def model(self) -> tuple[str, bytes]:
        """Return identifier and content of the model that described the shapes."""
        rows = self._rows("SELECT identifier, content FROM model")
        if len(rows) != 1:
            raise damaged(self.path, f"it holds {len(rows)} models instead of one")
        return rows[0]

    def summary(self) -> dict[str, int]:
        """Return how many shapes, sources and failed sources there are, and the bytes of the file."""
        names = ("shapes", "sources", "failed", "bytes", "schema")
        row = self._rows(
            "SELECT (SELECT count(*) FROM codes), (SELECT count(*) FROM sources),"
            " (SELECT count(error) FROM sources),"
            " (SELECT page_count * page_size FROM pragma_page_count, pragma_page_size),"
            " (SELECT CAST(value AS INTEGER) FROM meta WHERE key = 'schema')"
        )[0]
        return dict(zip(names, row, strict=True))

    @contextmanager
    def snapshot(self) -> Iterator[None]:
        """Let all reads inside see the file at one moment; writers wait meanwhile, so be quick."""
        with self._explained(), self._transaction("BEGIN"):
            yield

    # -- changes --------------------------------------------------------------------------------------------

    def add(self, source: str, shape: NewShape) -> int:
        """Add one shape; one with the same source, object name and name makes room for it.

        Parameters
        ----------
        source : str
            Empty: the shape has no source and replaces nothing.
        shape : NewShape

        Returns
        -------
        shape_id : int
        """
        with self._writing() as connection:
            source_id = None
            if source:
                connection.execute(
                    "INSERT OR IGNORE INTO sources (path) VALUES (CAST(? AS TEXT))", (_encoded(source),)
                )
                source_id = self._source_id(source)
                self._remove(
                    "source_id = ? AND object_name = CAST(? AS TEXT) AND name = CAST(? AS TEXT)",
                    (source_id, _encoded(shape.object_name), _encoded(shape.name)),
                )
            return self._insert(source_id, shape)

    def replace_source(self, source: SourceRecord, shapes: Iterable[NewShape]) -> list[int]:
        """Forget what a source gave before and put in what it gives now.

        Parameters
        ----------
        source : SourceRecord
            Its `shape_count` is not looked at.
        shapes : iterable of NewShape

        Returns
        -------
        shape_ids : list of int
            In the order of `shapes`.
        """
        with self._writing() as connection:
            path = _encoded(source.path)
            self._remove_source(path)
            connection.execute(
                "INSERT INTO sources (path, size, mtime_ns, sha256, error)"
                " VALUES (CAST(? AS TEXT), ?, ?, ?, CAST(? AS TEXT))",
                (
                    path,
                    source.size,
                    source.mtime_ns,
                    source.sha256,
                    None if source.error is None else _encoded(source.error),
                ),
            )
            source_id = self._source_id(source.path)
            return [self._insert(source_id, shape) for shape in shapes]

    def update_source(self, path: str, size: int, mtime_ns: int) -> bool:
        """Note a source's new size and time of change; False when the source is not known."""
        with self._writing() as connection:
            cursor = connection.execute(
                "UPDATE sources SET size = ?, mtime_ns = ? WHERE path = CAST(? AS TEXT)",
                (size, mtime_ns, _encoded(path)),
            )
            return cursor.rowcount > 0

    def remove_sources(self, paths: Iterable[str]) -> int:
        """Remove sources and all their shapes; returns how many of them were known."""
        with self._writing():
            return sum(self._remove_source(_encoded(path)) for path in paths)

    def remove_shapes(self, shape_ids: Iterable[int]) -> int:
        """Remove single shapes; returns how many of them were there."""
        with self._writing():
            return sum(self._remove("id = ?", (shape_id,)) for shape_id in shape_ids)

    def _remove(self, where: str, parameters: tuple[object, ...]) -> int:
        for table, blocks in self._code_blocks.items():
            self._losing_blocks[table] |= blocks.holding(where, parameters)
        return self._connection.execute(f"DELETE FROM shapes WHERE {where}", parameters).rowcount

    def _remove_source(self, path: bytes) -> int:
        self._remove("source_id = (SELECT id FROM sources WHERE path = CAST(? AS TEXT))", (path,))
        return self._connection.execute("DELETE FROM sources WHERE path = CAST(? AS TEXT)", (path,)).rowcount

    def _source_id(self, path: str) -> int:
        return int(self._value("SELECT id FROM sources WHERE path = CAST(? AS TEXT)", _encoded(path)))

    def _insert(self, source_id: int | None, shape: NewShape) -> int:
        signature = shape.signature
        shape_id = self._connection.execute(
            "INSERT INTO shapes (source_id, object_name, name, vertex_count, face_count, area)"
            " VALUES (?, CAST(? AS TEXT), CAST(? AS TEXT), ?, ?, ?)",
            (
                source_id,
                _encoded(shape.object_name),
                _encoded(shape.name),
                int(signature.vertex_count),
                int(signature.face_count),
                float(signature.area),
            ),
        ).lastrowid
        assert shape_id is not None  # an INSERT that did not raise has made a row
        self._connection.execute("INSERT INTO codes VALUES (?, ?)", (shape_id, signature.code.tobytes()))
        halves = signature.bags.astype(BAG_TYPE).tobytes()
        self._connection.execute("INSERT INTO bags VALUES (?, ?)", (shape_id, halves))
        if signature.sample is not None:
            self._connection.execute(
                "INSERT INTO samples VALUES (?, ?)", (shape_id, signature.sample.to_bytes())
            )
        if signature.local_code is not None and self.has_local_words():
            self._connection.execute(
                "INSERT INTO local_words VALUES (?, ?)", (shape_id, signature.local_code.tobytes())
            )
            self._code_blocks["local_words"].complete(shape_id)
        if shape.thumbnail is not None:
            self._connection.execute("INSERT INTO thumbnails VALUES (?, ?)", (shape_id, shape.thumbnail))
        self._code_blocks["codes"].complete(shape_id)
        return shape_id

    # -- reads ----------------------------------------------------------------------------------------------

    def count(self) -> int:
        """Return how many shapes there are."""
        # The smallest table that has a row for every shape.
        return int(self._value("SELECT count(*) FROM codes"))

    def sources(self) -> list[SourceRecord]:
        """All sources in the order of their paths."""
        rows = self._rows(
            "SELECT path, size, mtime_ns, sha256, error,"
            " (SELECT count(*) FROM shapes WHERE source_id = sources.id) FROM sources ORDER BY path"
        )
        return [SourceRecord(*row) for row in rows]

    def shapes_after(self, last_id: int, limit: int) -> list[ShapeRecord]:
        """Return the next shapes by id; start with `last_id` 0."""
        rows = self._rows(SELECT_SHAPES + "WHERE shapes.id > ? ORDER BY shapes.id LIMIT ?", last_id, limit)
        return [ShapeRecord(*row) for row in rows]

    def shapes(self, shape_ids: Sequence[int]) -> list[ShapeRecord]:
        """Return the shapes with these ids, in the order of their ids; unknown ids are left out."""
        return [
            ShapeRecord(*row) for row in self._rows_with_ids(SELECT_SHAPES + "WHERE shapes.id", shape_ids)
        ]

    def last_id(self) -> int:
        """Return the greatest id of a shape, 0 if there is none: there are at most so many shapes."""
        return int(self._value("SELECT coalesce(max(shape_id), 0) FROM codes"))

    def codes(self, code_bytes: int) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
        """Ids and codes of all shapes, in the order of the ids.

        Parameters
        ----------
        code_bytes : int
            Length of each code.

        Returns
        -------
        shape_ids : (n,) array of int64
        codes : (n, code_bytes) array of uint8
        """
        shape_ids: list[NDArray[np.int64]] = [np.empty(0, np.int64)]
        codes = [np.empty((0, code_bytes), np.uint8)]
        with self.snapshot():
            for page_ids, page in self.code_pages("codes", 0, code_bytes):
                shape_ids.append(page_ids)
                codes.append(page)
        return np.concatenate(shape_ids), np.concatenate(codes)

    def code_pages(
        self, table: str, last_id: int, code_bytes: int
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.uint8]]]:
        """Ids and codes of the shapes after an id, in portions; use them up within one `snapshot`.

        Parameters
        ----------
        table : str
            One of `CODE_TABLES`.
        last_id : int
            0: of all shapes. An id is never given twice: those after the last one seen are what is new.
        code_bytes : int
            Length of each code.

        Yields
        ------
        shape_ids : (n,) array of int64
        codes : (n, code_bytes) array of uint8
        """
        with self._explained():
            for shape_ids, blobs in self._code_blocks[table].pages(last_id):
                content = b"".join(blobs)
                if len(content) != len(shape_ids) * code_bytes:
                    raise damaged(self.path, "a code has another length than its model's")
                yield shape_ids, np.frombuffer(content, np.uint8).reshape(len(shape_ids), code_bytes)

    def bags(self, shape_ids: Sequence[int], bag_size: int) -> tuple[list[int], NDArray[np.float32]]:
        """Return ids (sorted; unknown ones left out) and bags (n, bag_size) of these shapes."""
        return self._unpacked(
            self._rows_with_ids("SELECT shape_id, halves FROM bags WHERE shape_id", shape_ids),
            bag_size,
        )

    def bags_after(self, last_id: int, limit: int, bag_size: int) -> tuple[list[int], NDArray[np.float32]]:
        """Return ids and bags (n, bag_size) of the next shapes by id; start with `last_id` 0."""
        return self._unpacked(
            self._rows(
                "SELECT shape_id, halves FROM bags WHERE shape_id > ? ORDER BY shape_id LIMIT ?",
                last_id,
                limit,
            ),
            bag_size,
        )

    def code(self, shape_id: int, code_bytes: int) -> NDArray[np.uint8] | None:
        """Return the code of one shape, or None when there is no such shape."""
        return self._code("codes", shape_id, code_bytes)

    def codes_of(self, shape_ids: Sequence[int], code_bytes: int) -> tuple[list[int], NDArray[np.uint8]]:
        """Return ids (sorted; unknown ones left out) and codes (n, code_bytes) of these shapes."""
        rows = self._rows_with_ids("SELECT shape_id, code FROM codes WHERE shape_id", shape_ids)
        return [row[0] for row in rows], self._matrix(
            [row[1] for row in rows], np.dtype(np.uint8), code_bytes
        )

    def local_code(self, shape_id: int, code_bytes: int) -> NDArray[np.uint8] | None:
        """Return the local words of one shape, or None when it has none."""
        return self._code("local_words", shape_id, code_bytes) if self.has_local_words() else None

    def has_local_words(self) -> bool:
        """Whether there is an index of parts: libraries of a format before 5 have none."""
        return bool(self._value("SELECT count(*) FROM sqlite_master WHERE name = 'local_words'"))

    def _code(self, table: str, shape_id: int, code_bytes: int) -> NDArray[np.uint8] | None:
        rows = self._rows(f"SELECT code FROM {table} WHERE shape_id = ?", shape_id)
        return self._matrix([rows[0][0]], np.dtype(np.uint8), code_bytes)[0] if rows else None

    def samples(self, shape_ids: Sequence[int]) -> dict[int, bytes]:
        """Return the surface samples of these shapes by id, as `SurfaceSample.to_bytes` made them."""
        return dict(self._rows_with_ids("SELECT shape_id, content FROM samples WHERE shape_id", shape_ids))

    def thumbnail(self, shape_id: int) -> bytes | None:
        """Return the picture of one shape as PNG, or None when it has none."""
        rows = self._rows("SELECT png FROM thumbnails WHERE shape_id = ?", shape_id)
        return rows[0][0] if rows else None

    # -- helpers --------------------------------------------------------------------------------------------

    def _unpacked(
        self, rows: list[tuple[int, bytes]], bag_size: int
    ) -> tuple[list[int], NDArray[np.float32]]:
        halves = self._matrix([row[1] for row in rows], BAG_TYPE, bag_size)
        return [row[0] for row in rows], halves.astype(np.float32)

    def _matrix(self, blobs: list[bytes], dtype: np.dtype[Any], width: int) -> NDArray[Any]:
        if any(len(blob) != width * dtype.itemsize for blob in blobs):
            raise damaged(self.path, "a bag or code has another length than its model's")
        return np.frombuffer(b"".join(blobs), dtype).reshape(len(blobs), width)

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
            for losing in self._losing_blocks.values():
                losing.clear()
            yield self._connection
            for table, losing in self._losing_blocks.items():
                self._code_blocks[table].pack(losing)
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


def round_bags(bags: NDArray[np.float32]) -> NDArray[np.float32]:
    """Bags as they would come back from a store.

    Parameters
    ----------
    bags : array of float32

    Returns
    -------
    rounded : array of float32
        To 11 significant bits; infinite where half floats end, beyond 65,504.
    """
    with np.errstate(over="ignore"):
        return bags.astype(BAG_TYPE).astype(np.float32)


def _uri(path: Path, mode: str) -> str:
    """``file:`` URI of a path; Windows drives and network shares included.

    `Path.as_uri` puts a share's host where SQLite refuses it: it wants an empty host, then the whole path.
    """
    absolute = path.absolute().as_posix()
    return f"file://{'' if absolute.startswith('/') else '/'}{quote(os.fsencode(absolute))}?mode={mode}"


def _encoded(text: str) -> bytes:
    """Bytes of a name. File names need not be valid Unicode; sqlite3 takes such ones only as bytes."""
    return text.encode("utf-8", "surrogatepass")


def _decoded(content: bytes) -> str:
    return content.decode("utf-8", "surrogatepass")
