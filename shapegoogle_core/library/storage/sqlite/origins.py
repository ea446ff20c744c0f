# SPDX-License-Identifier: MIT
"""SQL of the table `origins`: what shapes are in their files."""

from __future__ import annotations

from collections.abc import Sequence

from shapegoogle_core.library.origin import UNKNOWN, Origin
from shapegoogle_core.library.storage.shape_records import origins_from
from shapegoogle_core.library.storage.sqlite.database import Database, encoded
from shapegoogle_core.library.storage.sqlite.schema import SCHEMA_OF_ORIGINS

__all__ = ["OriginTable"]


class OriginTable(Database):
    """Types, catalogs and frames of the shapes of a library file."""

    def has_origins(self) -> bool:
        """Return whether the file has the table: the first shape that needs it adds it."""
        statement = "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = 'origins'"
        return self.value(statement) is not None

    def insert_origin(self, shape_id: int, origin: Origin, object_name: str) -> None:
        """Insert the origin of a new shape, inside `writing`, unless it is that of a shape without a row."""
        origin = origin.completed(object_name)
        if origin == UNKNOWN.completed(object_name):
            return
        self.connection.execute(SCHEMA_OF_ORIGINS)
        self.connection.execute(
            "INSERT INTO origins VALUES (?, ?, CAST(? AS TEXT), ?)",
            (shape_id, origin.shape_type, encoded(origin.catalog), origin.frame),
        )

    def origins(self, shape_ids: Sequence[int]) -> dict[int, Origin]:
        """Return the origins of those of some shapes that have a row, by id."""
        if not self.has_origins():
            return {}
        columns = "shape_id, shape_type, catalog, frame"
        rows = self.rows_with_ids(f"SELECT {columns} FROM origins WHERE shape_id", shape_ids)
        return origins_from(rows)
