# SPDX-License-Identifier: MIT
"""SQL of what finds shapes of the same kind: views, and nearest neighbours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.storage.neighbour_rows import neighbour_rows, neighbours_from
from shapegoogle_core.library.storage.postgresql.database import Database
from shapegoogle_core.library.storage.records import SourceKey
from shapegoogle_core.library.storage.store import Neighbours

__all__ = ["KindTables"]


class KindTables(Database):
    """Views and neighbours of the shapes of a library in a database."""

    def views(self, shape_ids: Sequence[int], size: int) -> tuple[list[int], NDArray[np.uint8]]:
        """Return ids and views of some shapes, see `Store.views`."""
        rows = self.rows_with_ids("SELECT shape_id, descriptors FROM views WHERE shape_id", shape_ids)
        return [row[0] for row in rows], self.matrix([row[1] for row in rows], np.dtype(np.uint8), size)

    def neighbours(self, shape_ids: Sequence[int]) -> dict[int, Neighbours]:
        """Return the nearest shapes of some shapes, see `Store.neighbours`."""
        rows = self.rows_with_ids("SELECT shape_id, ids, distances FROM neighbours WHERE shape_id", shape_ids)
        return neighbours_from(rows, self.damaged)

    def put_neighbours(self, neighbours: Mapping[int, Neighbours]) -> None:
        """Store the nearest shapes of some shapes, see `Store.put_neighbours`."""
        with self.writing():
            self.insert_neighbours(neighbours)

    def insert_neighbours(self, neighbours: Mapping[int, Neighbours]) -> None:
        """Insert or replace the nearest shapes of some shapes, inside `writing`."""
        with self.connection.cursor() as cursor:
            # The condition leaves out shapes that were removed in the meantime.
            cursor.executemany(
                "INSERT INTO neighbours SELECT id, %b, %b FROM shapes WHERE id = %b ON CONFLICT (shape_id)"
                " DO UPDATE SET ids = excluded.ids, distances = excluded.distances",
                [(ids, distances, shape_id) for shape_id, ids, distances in neighbour_rows(neighbours)],
            )

    def without_neighbours(self, last_id: int, limit: int) -> list[int]:
        """Return the next shapes without neighbours, see `Store.without_neighbours`."""
        rows = self.rows(
            "SELECT id FROM shapes WHERE id > %s"
            " AND NOT EXISTS (SELECT 1 FROM neighbours WHERE shape_id = id) ORDER BY id LIMIT %s",
            *(last_id, limit),
        )
        return [row[0] for row in rows]

    def count_without_views(self) -> int:
        """Return the number of shapes without views, see `Store.count_without_views`."""
        return int(self.value("SELECT (SELECT count(*) FROM codes) - (SELECT count(*) FROM view_codes)"))

    def sources_without_views(self) -> list[SourceKey]:
        """Return the sources of shapes without views, see `Store.sources_without_views`."""
        rows = self.rows(
            "SELECT DISTINCT coalesce(roots.name, ''), sources.path FROM shapes"
            " JOIN sources ON sources.id = source_id LEFT JOIN roots ON roots.id = root_id"
            " WHERE NOT EXISTS (SELECT 1 FROM view_codes WHERE shape_id = shapes.id)"
        )
        return [SourceKey(*row) for row in rows]
