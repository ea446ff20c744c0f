# SPDX-License-Identifier: MIT
"""SQL of shapes: their records, tags, placements, samples, measures and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.storage.filter_conditions import filter_conditions, kept_by_area
from shapegoogle_core.library.storage.postgresql.sources import SourceTable
from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.library.storage.shape_records import origins_from, shape_records

__all__ = ["ShapeTable"]

SELECT_SHAPES = """
SELECT shapes.id, shapes.name, roots.path, coalesce(sources.path, ''), object_name, vertex_count, face_count,
    area, extent_x, extent_y, extent_z, placement_count
FROM shapes LEFT JOIN sources ON sources.id = source_id LEFT JOIN roots ON roots.id = root_id
"""


class ShapeTable(SourceTable):
    """Records, surface samples and pictures of the shapes of a library in a database."""

    def shapes(self, shape_ids: Sequence[int]) -> list[ShapeRecord]:
        """Return the records of some shapes, see `Store.shapes`."""
        return self._with_tags(self.rows_with_ids(SELECT_SHAPES + "WHERE shapes.id", shape_ids))

    def shapes_after(self, last_id: int, limit: int) -> list[ShapeRecord]:
        """Return the records of the next shapes, see `Store.shapes_after`."""
        return self._with_tags(
            self.rows(SELECT_SHAPES + "WHERE shapes.id > %s ORDER BY shapes.id LIMIT %s", last_id, limit)
        )

    def _with_tags(self, rows: list[tuple[Any, ...]]) -> list[ShapeRecord]:
        shape_ids = [row[0] for row in rows]
        tags = self.rows_with_ids("SELECT shape_id, tag FROM tags WHERE shape_id", shape_ids)
        columns = "shape_id, shape_type, catalog, frame"
        origins = self.rows_with_ids(f"SELECT {columns} FROM origins WHERE shape_id", shape_ids)
        return shape_records(rows, tags, origins_from(origins), self.local_folders)

    def filtered_ids(self, where: Filter) -> NDArray[np.int64]:
        """Find the shapes that meet a filter, see `Store.filtered_ids`."""
        condition, parameters = filter_conditions(where, self.roots(), self.dialect)
        rows = self.rows(f"SELECT id, area FROM shapes WHERE {condition} ORDER BY id", *parameters)
        return np.array(kept_by_area(where, rows, self.placements), np.int64)
