# SPDX-License-Identifier: MIT
"""The library file: with its tables (`schema`) and packed codes (`code_blocks`) the only place with SQL.

A shared PostgreSQL library would be another class with the methods of `Store`.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.storage.records import NewShape, ShapeRecord, SourceRecord
from shapegoogle_core.library.storage.sqlite.code_blocks import CODE_TABLES, CodeBlocks
from shapegoogle_core.library.storage.sqlite.database import Database, encoded
from shapegoogle_core.library.storage.sqlite.errors import damaged
from shapegoogle_core.library.storage.sqlite.schema import (
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


class Store(Database):
    """An open library file.

    Every method raises `LibraryError`, never an error of sqlite3. Every change is one transaction: all of it
    is in the file when the method returns, or nothing. Use it only in the thread that made it.

    Parameters are those of `Database`.
    """

    def __init__(self, path: Path, *, create: bool, read_only: bool, timeout: float) -> None:
        super().__init__(path, create=create, read_only=read_only, timeout=timeout)
        self._code_blocks = {table: CodeBlocks(self._connection, table) for table in CODE_TABLES}
        # Those that lose a shape in the running transaction.
        self._losing_blocks: dict[str, set[int]] = {table: set() for table in CODE_TABLES}

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
                    "INSERT OR IGNORE INTO sources (path) VALUES (CAST(? AS TEXT))", (encoded(source),)
                )
                source_id = self._source_id(source)
                self._remove(
                    "source_id = ? AND object_name = CAST(? AS TEXT) AND name = CAST(? AS TEXT)",
                    (source_id, encoded(shape.object_name), encoded(shape.name)),
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
            path = encoded(source.path)
            self._remove_source(path)
            connection.execute(
                "INSERT INTO sources (path, size, mtime_ns, sha256, error)"
                " VALUES (CAST(? AS TEXT), ?, ?, ?, CAST(? AS TEXT))",
                (
                    path,
                    source.size,
                    source.mtime_ns,
                    source.sha256,
                    None if source.error is None else encoded(source.error),
                ),
            )
            source_id = self._source_id(source.path)
            return [self._insert(source_id, shape) for shape in shapes]

    def update_source(self, path: str, size: int, mtime_ns: int) -> bool:
        """Note a source's new size and time of change; False when the source is not known."""
        with self._writing() as connection:
            cursor = connection.execute(
                "UPDATE sources SET size = ?, mtime_ns = ? WHERE path = CAST(? AS TEXT)",
                (size, mtime_ns, encoded(path)),
            )
            return cursor.rowcount > 0

    def remove_sources(self, paths: Iterable[str]) -> int:
        """Remove sources and all their shapes; returns how many of them were known."""
        with self._writing():
            return sum(self._remove_source(encoded(path)) for path in paths)

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
        return int(self._value("SELECT id FROM sources WHERE path = CAST(? AS TEXT)", encoded(path)))

    def _insert(self, source_id: int | None, shape: NewShape) -> int:
        signature = shape.signature
        shape_id = self._connection.execute(
            "INSERT INTO shapes (source_id, object_name, name, vertex_count, face_count, area)"
            " VALUES (?, CAST(? AS TEXT), CAST(? AS TEXT), ?, ?, ?)",
            (
                source_id,
                encoded(shape.object_name),
                encoded(shape.name),
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

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        with super()._writing() as connection:
            for losing in self._losing_blocks.values():
                losing.clear()
            yield connection
            for table, losing in self._losing_blocks.items():
                self._code_blocks[table].pack(losing)


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
