# SPDX-License-Identifier: MIT
"""SQL of binary codes and bags."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.storage.postgresql.adapters import code_rows
from shapegoogle_core.library.storage.postgresql.shapes import ShapeTable
from shapegoogle_core.library.storage.signatures import BAG_TYPE
from shapegoogle_core.library.storage.store import CodeKind, CodePage

__all__ = ["CodeTables"]

# Codes that one COPY brings: 70 MB of local words at most.
CODES_AT_ONCE = 250_000


class CodeTables(ShapeTable):
    """Codes and bags of a library in a database."""

    codes_at_once = CODES_AT_ONCE

    def code_pages(self, kind: CodeKind, last_id: int, code_bytes: int) -> Iterator[CodePage]:
        """Read the codes of all shapes after an id, see `Store.code_pages`."""
        statement = (
            f"COPY (SELECT shape_id, code FROM {kind} WHERE shape_id > %s ORDER BY shape_id LIMIT %s)"
            " TO STDOUT (FORMAT BINARY)"
        ).encode()
        while True:
            with (
                self.explained(),
                self.connection.cursor() as cursor,
                cursor.copy(statement, (last_id, self.codes_at_once)) as copy,
            ):
                page = code_rows(iter(copy), code_bytes)
            if page is None:
                raise self.damaged("a code has another length than its model's")
            if len(page[0]):
                yield page
            if len(page[0]) < self.codes_at_once:
                return
            last_id = int(page[0][-1])

    def codes(self, kind: CodeKind, shape_ids: Sequence[int], code_bytes: int) -> CodePage:
        """Return ids and codes of some shapes, see `Store.codes`."""
        rows = self.rows_with_ids(f"SELECT shape_id, code FROM {kind} WHERE shape_id", shape_ids)
        codes = self.matrix([row[1] for row in rows], np.dtype(np.uint8), code_bytes)
        return np.array([row[0] for row in rows], np.int64), codes

    def count(self) -> int:
        """Return the number of shapes, from the smallest table with a row for each of them."""
        return int(self.value("SELECT count(*) FROM codes"))

    def bags(self, shape_ids: Sequence[int], bag_size: int) -> tuple[list[int], NDArray[np.float32]]:
        """Return ids and bags of some shapes, see `Store.bags`."""
        rows = self.rows_with_ids("SELECT shape_id, halves FROM bags WHERE shape_id", shape_ids)
        return self._unpacked(rows, bag_size)

    def bags_after(self, last_id: int, limit: int, bag_size: int) -> tuple[list[int], NDArray[np.float32]]:
        """Return ids and bags of the next shapes, see `Store.bags_after`."""
        rows = self.rows(
            "SELECT shape_id, halves FROM bags WHERE shape_id > %s ORDER BY shape_id LIMIT %s", last_id, limit
        )
        return self._unpacked(rows, bag_size)

    def _unpacked(
        self, rows: list[tuple[int, bytes]], bag_size: int
    ) -> tuple[list[int], NDArray[np.float32]]:
        halves = self.matrix([row[1] for row in rows], BAG_TYPE, bag_size)
        return [row[0] for row in rows], halves.astype(np.float32)
