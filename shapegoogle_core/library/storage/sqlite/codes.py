# SPDX-License-Identifier: MIT
"""SQL of the tables `codes` and `local_words`: binary codes of shapes, also packed in blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from shapegoogle_core.library.storage.sqlite.code_blocks import (
    BLOCK_IDS,
    BLOCK_TABLES,
    ROWS_AT_ONCE,
    CodeBlocks,
)
from shapegoogle_core.library.storage.sqlite.database import Database
from shapegoogle_core.library.storage.store import CodeKind, CodePage
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["CodeTables"]


class CodeTables(Database):
    """Codes of a library file.

    Parameters
    ----------
    path, create, read_only, timeout
        See `Database`.

    Attributes
    ----------
    block_ids, rows_at_once : int
        See `CodeBlocks`.
    """

    block_ids = BLOCK_IDS
    rows_at_once = ROWS_AT_ONCE

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Run changes as one transaction, which ends with packing the blocks that lost shapes."""
        with super().writing():
            # Blocks that lose a shape in this transaction.
            self._incomplete: dict[CodeKind, set[int]] = {kind: set() for kind in BLOCK_TABLES}
            yield
            for kind, blocks in self._incomplete.items():
                self._blocks(kind).pack(blocks)

    def insert_codes(self, shape_id: int, signature: ShapeSignature) -> None:
        """Insert the codes of a new shape, inside `writing`."""
        for table, code in (("codes", signature.code), ("local_words", signature.local_code)):
            if code is not None:
                self.connection.execute(f"INSERT INTO {table} VALUES (?, ?)", (shape_id, code.tobytes()))
        for kind in BLOCK_TABLES:
            self._blocks(kind).complete(shape_id)

    def note_removal(self, where: str, parameters: tuple[object, ...]) -> None:
        """Remember the blocks of shapes that are about to be removed; see `CodeBlocks.holding`."""
        for kind, blocks in self._incomplete.items():
            blocks |= self._blocks(kind).holding(where, parameters)

    def code_pages(self, kind: CodeKind, last_id: int, code_bytes: int) -> Iterator[CodePage]:
        """Read the codes of all shapes after an id, see `Store.code_pages`."""
        with self.explained():
            for shape_ids, blobs in self._blocks(kind).pages(last_id):
                content = b"".join(blobs)
                if len(content) != len(shape_ids) * code_bytes:
                    raise self.damaged("a code has another length than its model's")
                yield shape_ids, np.frombuffer(content, np.uint8).reshape(len(shape_ids), code_bytes)

    def codes(self, kind: CodeKind, shape_ids: Sequence[int], code_bytes: int) -> CodePage:
        """Return ids and codes of some shapes, see `Store.codes`."""
        rows = self.rows_with_ids(f"SELECT shape_id, code FROM {kind} WHERE shape_id", shape_ids)
        codes = self.matrix([row[1] for row in rows], np.dtype(np.uint8), code_bytes)
        return np.array([row[0] for row in rows], np.int64), codes

    def count(self) -> int:
        """Return the number of shapes, from the smallest table with a row for each of them."""
        return int(self.value("SELECT count(*) FROM codes"))

    def _blocks(self, kind: CodeKind) -> CodeBlocks:
        return CodeBlocks(self.connection, kind, self.block_ids, self.rows_at_once)
