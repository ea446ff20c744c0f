# SPDX-License-Identifier: MIT
"""SQL of binary codes and bags."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.storage.postgresql.adapters import Bits, code_rows
from shapegoogle_core.library.storage.postgresql.shapes import ShapeTable
from shapegoogle_core.library.storage.signatures import BAG_TYPE
from shapegoogle_core.library.storage.store import CodeKind, CodePage

__all__ = ["CODE_INDEX", "CodeTables"]

# Codes that one COPY brings: 70 MB of local words at most.
CODES_AT_ONCE = 250_000
COMPARED_IN_MEMORY = 2_000_000
"""Number of codes up to which whoever searches keeps them in memory; beyond it the database compares them."""

CODE_INDEX = "codes_nearest"
"""Name of the index that pgvector finds near codes with."""

PROBED = 10
"""One of so many lists of that index is searched (docs/reference/database.md)."""


class CodeTables(ShapeTable):
    """Codes and bags of a library in a database."""

    codes_at_once = CODES_AT_ONCE
    compared_in_memory = COMPARED_IN_MEMORY

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

    @cached_property
    def _in_memory(self) -> bool:
        """Whether the codes are few enough to be compared in memory."""
        return self.count() <= self.compared_in_memory

    def index_lists(self) -> int:
        """Return the number of lists of the index of codes; 0 if there is none that can be used."""
        options: list[str] | None = self.value(
            "SELECT reloptions FROM pg_class JOIN pg_index ON indexrelid = oid"
            " WHERE oid = to_regclass(%s) AND indisvalid",
            CODE_INDEX,
        )
        return int(dict(option.split("=") for option in options)["lists"]) if options else 0

    def vector_schema(self) -> str | None:
        """Return the schema that pgvector is installed in, quoted; None if it is not."""
        schema: str | None = self.value(
            "SELECT quote_ident(nspname) FROM pg_extension"
            " JOIN pg_namespace ON pg_namespace.oid = extnamespace WHERE extname = 'vector'"
        )
        return schema

    def nearest_codes(
        self, code: NDArray[np.uint8], count: int, among: NDArray[np.int64] | None = None
    ) -> NDArray[np.int64] | None:
        """Find the nearest codes in the database if they are many, see `Store.nearest_codes`."""
        if self._in_memory:
            return None
        bits = Bits(code.tobytes())
        lists = 0 if among is not None else self.index_lists()
        if lists:
            hamming = f"OPERATOR({self.vector_schema()}.<~>)"
            with self.snapshot():
                self.rows("SELECT set_config('ivfflat.probes', %s, TRUE)", str(max(1, lists // PROBED)))
                rows = self.rows(
                    f"SELECT shape_id, code {hamming} %s FROM codes ORDER BY code {hamming} %s LIMIT %s",
                    *(bits, bits, count),
                )
        elif among is not None:
            rows = self.rows(
                "SELECT shape_id, bit_count(code # %s) FROM codes WHERE shape_id = ANY(%s::bigint[])"
                " ORDER BY 2, 1 LIMIT %s",
                *(bits, among.tolist(), count),
            )
        else:
            rows = self.rows(
                "SELECT shape_id, bit_count(code # %s) FROM codes ORDER BY 2, 1 LIMIT %s", bits, count
            )
        rows.sort(key=lambda row: (row[1], row[0]))
        return np.fromiter((row[0] for row in rows), np.int64, len(rows))

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
