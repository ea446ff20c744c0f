# SPDX-License-Identifier: MIT
"""SQL of the tables `shapes`, `tags`, `samples` and `thumbnails`: all of a shape but its bags and codes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.storage.filter_conditions import filter_conditions, kept_by_area
from shapegoogle_core.library.storage.placement_rows import placement_rows
from shapegoogle_core.library.storage.records import NewShape, ShapeRecord
from shapegoogle_core.library.storage.shape_records import shape_records
from shapegoogle_core.library.storage.sqlite.database import encoded
from shapegoogle_core.library.storage.sqlite.dialect import fold_case
from shapegoogle_core.library.storage.sqlite.origins import OriginTable
from shapegoogle_core.library.storage.sqlite.sources import SourceTable
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["ShapeTable"]

SELECT_SHAPES = """
SELECT shapes.id, shapes.name, roots.path, coalesce(sources.path, ''), object_name, vertex_count, face_count,
    area, extent_x, extent_y, extent_z, placement_count
FROM shapes LEFT JOIN sources ON sources.id = source_id LEFT JOIN roots ON roots.id = root_id
"""


class ShapeTable(OriginTable, SourceTable):
    """Records, surface samples and pictures of the shapes of a library file."""

    def insert_record(
        self, source_id: int | None, shape: NewShape[ShapeSignature], number: int | None = None
    ) -> int:
        """Insert record, tags, sample and picture of a new shape, inside `writing`; return its id.

        It is the next one, unless a number is given.
        """
        signature = shape.signature
        counts = int(signature.vertex_count), int(signature.face_count)
        sizes = float(signature.area), *map(float, signature.extents)
        placement_count = max(1, len(shape.placements))
        shape_id = self.connection.execute(
            "INSERT INTO shapes (id, source_id, object_name, name, vertex_count, face_count, area,"
            " extent_x, extent_y, extent_z, placement_count)"
            " VALUES (?, ?, CAST(? AS TEXT), CAST(? AS TEXT), ?, ?, ?, ?, ?, ?, ?)",
            (
                number,
                source_id,
                encoded(shape.object_name),
                encoded(shape.name),
                *counts,
                *sizes,
                placement_count,
            ),
        ).lastrowid
        assert shape_id is not None  # an INSERT that did not raise has made a row
        self.connection.executemany(
            "INSERT OR IGNORE INTO tags VALUES (?, CAST(? AS TEXT))",
            [(shape_id, encoded(tag)) for tag in shape.tags],
        )
        self.connection.executemany(
            "INSERT INTO placements VALUES (?, ?, CAST(? AS TEXT), ?, ?, ?, ?)",
            [
                (shape_id, position, encoded(name), *row)
                for position, name, *row in placement_rows(shape.placements, signature.extents)
            ],
        )
        self.insert_origin(shape_id, shape.origin, shape.object_name)
        if signature.sample is not None:
            content = signature.sample.to_bytes()
            self.connection.execute("INSERT INTO samples VALUES (?, ?)", (shape_id, content))
        if signature.measures is not None:
            content = signature.measures.to_bytes()
            self.connection.execute("INSERT INTO measures VALUES (?, ?)", (shape_id, content))
        if shape.thumbnail is not None:
            self.connection.execute("INSERT INTO thumbnails VALUES (?, ?)", (shape_id, shape.thumbnail))
        return shape_id

    def shapes(self, shape_ids: Sequence[int]) -> list[ShapeRecord]:
        """Return the records of some shapes, see `Store.shapes`."""
        rows = self.rows_with_ids(SELECT_SHAPES + "WHERE shapes.id", shape_ids)
        origins = self.origins(shape_ids)
        if not self._has_tags():
            return shape_records(rows, [], origins, self.local_folders)
        tags = self.rows_with_ids("SELECT shape_id, tag FROM tags WHERE shape_id", shape_ids)
        return shape_records(rows, tags, origins, self.local_folders)

    def shapes_after(self, last_id: int, limit: int) -> list[ShapeRecord]:
        """Return the records of the next shapes, see `Store.shapes_after`."""
        rows = self.rows(SELECT_SHAPES + "WHERE shapes.id > ? ORDER BY shapes.id LIMIT ?", last_id, limit)
        if not rows:
            return []
        tags = self.rows(
            "SELECT shape_id, tag FROM tags WHERE shape_id BETWEEN ? AND ?", rows[0][0], rows[-1][0]
        )
        return shape_records(rows, tags, self.origins([row[0] for row in rows]), self.local_folders)

    def filtered_ids(self, where: Filter) -> NDArray[np.int64]:
        """Find the shapes that meet a filter, see `Store.filtered_ids`."""
        condition, parameters = filter_conditions(
            where, self.roots(), self.dialect, with_origins=self.has_origins()
        )
        with self.explained():
            self.connection.create_function("fold_case", 1, fold_case, deterministic=True)
        rows = self.rows(f"SELECT id, area FROM shapes WHERE {condition} ORDER BY id", *parameters)
        return np.array(kept_by_area(where, rows, self.placements), np.int64)

    def _has_tags(self) -> bool:
        """Return whether any shape has a tag: a search then saves one query."""
        return self.value("SELECT 1 FROM tags LIMIT 1") is not None
