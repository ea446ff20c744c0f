# SPDX-License-Identifier: MIT
"""SQL of the table `bags`: bags of words of shapes, as half floats."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.storage.signatures import BAG_TYPE
from shapegoogle_core.library.storage.sqlite.database import Database

__all__ = ["BagTable"]


class BagTable(Database):
    """Bags of a library file."""

    def insert_bags(self, shape_id: int, bags: NDArray[np.float32]) -> None:
        """Insert the bags of a new shape, inside `writing`."""
        self.connection.execute("INSERT INTO bags VALUES (?, ?)", (shape_id, bags.astype(BAG_TYPE).tobytes()))

    def bags(self, shape_ids: Sequence[int], bag_size: int) -> tuple[list[int], NDArray[np.float32]]:
        """Return ids and bags of some shapes, see `Store.bags`."""
        rows = self.rows_with_ids("SELECT shape_id, halves FROM bags WHERE shape_id", shape_ids)
        return self._unpacked(rows, bag_size)

    def bags_after(self, last_id: int, limit: int, bag_size: int) -> tuple[list[int], NDArray[np.float32]]:
        """Return ids and bags of the next shapes, see `Store.bags_after`."""
        rows = self.rows(
            "SELECT shape_id, halves FROM bags WHERE shape_id > ? ORDER BY shape_id LIMIT ?", last_id, limit
        )
        return self._unpacked(rows, bag_size)

    def _unpacked(
        self, rows: list[tuple[int, bytes]], bag_size: int
    ) -> tuple[list[int], NDArray[np.float32]]:
        halves = self.matrix([row[1] for row in rows], BAG_TYPE, bag_size)
        return [row[0] for row in rows], halves.astype(np.float32)
