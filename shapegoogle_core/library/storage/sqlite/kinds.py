# SPDX-License-Identifier: MIT
"""SQL of what finds shapes of the same kind: views, and nearest neighbours.

Libraries of format 7 have none of these tables. They are read as if the tables were empty, and the first
change adds them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.storage.neighbour_rows import neighbour_rows, neighbours_from
from shapegoogle_core.library.storage.records import SourceKey
from shapegoogle_core.library.storage.sqlite.database import Database
from shapegoogle_core.library.storage.sqlite.schema import FORMAT, SCHEMA_OF_KINDS
from shapegoogle_core.library.storage.store import Neighbours
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["KindTables"]


class KindTables(Database):
    """Views and neighbours of the shapes of a library file.

    Attributes
    ----------
    block_ids : int
        See `CodeBlocks`.
    """

    block_ids: int
    _kind_tables = False
    _new_model: tuple[bytes, str] | None = None

    def has_kind_tables(self) -> bool:
        """Return whether the file has these tables, or is empty yet."""
        if self._kind_tables:
            return True
        found = self.rows(
            "SELECT name FROM sqlite_master WHERE type = 'table' AND name IN ('shapes', 'views')"
        )
        has_tables = found != [("shapes",)]
        # Inside a transaction the tables may be those of this change, which may be undone.
        self._kind_tables = has_tables and not self.connection.in_transaction
        return has_tables

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Run changes as one transaction, which first adds the tables and the parts of the model it lacks."""
        with super().writing():
            if not self.has_kind_tables():
                self._add_kind_tables()
            if self._new_model is not None:
                self.connection.execute("UPDATE model SET content = ? WHERE identifier = ?", self._new_model)
            yield
        self._new_model = None

    def extend_model(self, identifier: str, content: bytes) -> None:
        """Store a more complete model with the next change, see `Store.extend_model`."""
        self._new_model = (content, identifier)

    def _add_kind_tables(self) -> None:
        """Create the tables, inside `writing`."""
        for statement in SCHEMA_OF_KINDS.format(block_ids=self.block_ids).split(";\n"):
            self.connection.execute(statement)
        self.connection.execute("UPDATE meta SET value = ? WHERE key = 'schema'", (str(FORMAT),))

    def insert_kind(self, shape_id: int, signature: ShapeSignature) -> None:
        """Insert the views of a new shape, inside `writing`."""
        if signature.views is not None:
            self.connection.execute("INSERT INTO views VALUES (?, ?)", (shape_id, signature.views.to_bytes()))

    def views(self, shape_ids: Sequence[int], size: int) -> tuple[list[int], NDArray[np.uint8]]:
        """Return ids and views of some shapes, see `Store.views`."""
        known = shape_ids if self.has_kind_tables() else []
        rows = self.rows_with_ids("SELECT shape_id, descriptors FROM views WHERE shape_id", known)
        return [row[0] for row in rows], self.matrix([row[1] for row in rows], np.dtype(np.uint8), size)

    def neighbours(self, shape_ids: Sequence[int]) -> dict[int, Neighbours]:
        """Return the nearest shapes of some shapes, see `Store.neighbours`."""
        known = shape_ids if self.has_kind_tables() else []
        rows = self.rows_with_ids("SELECT shape_id, ids, distances FROM neighbours WHERE shape_id", known)
        return neighbours_from(rows, self.damaged)

    def put_neighbours(self, neighbours: Mapping[int, Neighbours]) -> None:
        """Store the nearest shapes of some shapes, see `Store.put_neighbours`."""
        with self.writing():
            self.insert_neighbours(neighbours)

    def insert_neighbours(self, neighbours: Mapping[int, Neighbours]) -> None:
        """Insert or replace the nearest shapes of some shapes, inside `writing`."""
        # The condition leaves out shapes that were removed in the meantime.
        self.connection.executemany(
            "INSERT OR REPLACE INTO neighbours SELECT id, ?, ? FROM shapes WHERE id = ?",
            [(ids, distances, shape_id) for shape_id, ids, distances in neighbour_rows(neighbours)],
        )

    def without_neighbours(self, last_id: int, limit: int) -> list[int]:
        """Return the next shapes without neighbours, see `Store.without_neighbours`."""
        if not self.has_kind_tables():
            statement = "SELECT id FROM shapes WHERE id > ? ORDER BY id LIMIT ?"
        else:
            statement = (
                "SELECT id FROM shapes WHERE id > ? AND id NOT IN (SELECT shape_id FROM neighbours)"
                " ORDER BY id LIMIT ?"
            )
        return [row[0] for row in self.rows(statement, last_id, limit)]

    def count_without_views(self) -> int:
        """Return the number of shapes without views, see `Store.count_without_views`."""
        views = "(SELECT count(*) FROM view_codes)" if self.has_kind_tables() else "0"
        return int(self.value(f"SELECT (SELECT count(*) FROM codes) - {views}"))

    def sources_without_views(self) -> list[SourceKey]:
        """Return the sources of shapes without views, see `Store.sources_without_views`."""
        condition = " WHERE shapes.id NOT IN (SELECT shape_id FROM view_codes)"
        rows = self.rows(
            "SELECT DISTINCT coalesce(roots.name, ''), sources.path FROM shapes"
            " JOIN sources ON sources.id = source_id LEFT JOIN roots ON roots.id = root_id"
            + (condition if self.has_kind_tables() else "")
        )
        return [SourceKey(*row) for row in rows]
