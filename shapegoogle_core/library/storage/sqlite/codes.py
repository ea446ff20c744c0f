# SPDX-License-Identifier: MIT
"""SQL of the tables `codes`, `local_words` and `view_codes`: binary codes, and copies packed in blocks.

The rows of these tables lie scattered between bags and samples: reading a million of
them takes most of a second, and from a cold disk one seek for each page. So the codes of every 4,096
consecutive ids are also stored together in one row, as soon as all these ids are in use; ids are never given
twice and codes never change. Only codes added since the last full block are read row by row.

The rows count, the blocks are a copy. A trigger drops a block when one of its shapes is removed, and whatever
has no block is read row by row.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.storage.sqlite.kinds import KindTables
from shapegoogle_core.library.storage.store import CodeKind, CodePage
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["CodeBlocks", "CodeTables"]

# A read of some 140 KB for codes of 256 bits, and no more to write when one shape is removed.
BLOCK_IDS = 4_096
# As Python objects rows take several times the room of their codes.
ROWS_AT_ONCE = 50_000
# Place of an id within its block.
OFFSET_TYPE = np.dtype("<u2")

BLOCK_TABLES: dict[CodeKind, str] = {
    "codes": "code_blocks",
    "local_words": "local_word_blocks",
    "view_codes": "view_code_blocks",
}

CodeRows = tuple[NDArray[np.int64], list[bytes]]
"""Ids of shapes, and their codes: one string of bytes for each, or one for all."""


@dataclass(frozen=True)
class CodeBlocks:
    """The packed codes of an open library file, for use inside its transactions.

    Attributes
    ----------
    connection : sqlite3.Connection
        Its errors are not translated here.
    kind : {"codes", "local_words", "view_codes"}
        Also the name of the table of single rows.
    block_ids : int
        Number of ids in a block, as in the schema.
    rows_at_once : int
        Number of single rows in memory at once.
    """

    connection: sqlite3.Connection
    kind: CodeKind
    block_ids: int = BLOCK_IDS
    rows_at_once: int = ROWS_AT_ONCE

    @property
    def table(self) -> str:
        """Name of the table of blocks."""
        return BLOCK_TABLES[self.kind]

    def pages(self, last_id: int) -> Iterator[CodeRows]:
        """Read all codes after an id in the order of ids; use them up within one transaction.

        Parameters
        ----------
        last_id : int
            0 for all codes.

        Yields
        ------
        shape_ids : (n,) array of int64
        codes : list of bytes
        """
        # Block b holds the ids from b · 4,096 + 1 on; the first one entirely after `last_id`:
        first = -(-last_id // self.block_ids)
        blocks = self.connection.execute(
            f"SELECT block FROM {self.table} WHERE block >= ? ORDER BY block", (first,)
        ).fetchall()
        for (block,) in blocks:
            start = block * self.block_ids
            yield from self._rows(last_id, start)
            offsets, codes = self.connection.execute(
                f"SELECT offsets, codes FROM {self.table} WHERE block = ?", (block,)
            ).fetchone()
            yield start + 1 + np.frombuffer(offsets, OFFSET_TYPE).astype(np.int64), [codes]
            last_id = start + self.block_ids
        yield from self._rows(last_id, np.iinfo(np.int64).max)

    def complete(self, shape_id: int) -> None:
        """Pack all blocks up to the one that an id completes.

        Parameters
        ----------
        shape_id : int
            Of the shape that was just added. An id that completes no block does nothing.
        """
        if shape_id % self.block_ids:
            return
        packed = {number for (number,) in self.connection.execute(f"SELECT block FROM {self.table}")}
        self.pack(sorted(set(range(shape_id // self.block_ids)) - packed))

    def holding(self, where: str, parameters: Iterable[object]) -> set[int]:
        """Find the blocks that hold the codes of some shapes.

        Parameters
        ----------
        where : str
            Condition on the table `shapes`.
        parameters : iterable
            Values for its question marks.

        Returns
        -------
        blocks : set of int
        """
        statement = (
            f"SELECT block FROM {self.table} WHERE block IN"
            f" (SELECT (id - 1) / {self.block_ids} FROM shapes WHERE {where})"
        )
        return {number for (number,) in self.connection.execute(statement, tuple(parameters))}

    def pack(self, blocks: Iterable[int]) -> None:
        """Write these blocks again from the rows of codes."""
        for block in blocks:
            first = block * self.block_ids
            rows = list(self._rows(first, first + self.block_ids))
            shape_ids = np.concatenate([np.empty(0, np.int64), *(ids for ids, _ in rows)])
            codes = b"".join(code for _, page in rows for code in page)
            offsets = (shape_ids - first - 1).astype(OFFSET_TYPE).tobytes()
            self.connection.execute(
                f"INSERT OR REPLACE INTO {self.table} VALUES (?, ?, ?)", (block, offsets, codes)
            )

    def _rows(self, last_id: int, end_id: int) -> Iterator[CodeRows]:
        """Read single codes after one id, up to and including another one, in pages."""
        while True:
            rows = self.connection.execute(
                f"SELECT shape_id, code FROM {self.kind} WHERE shape_id > ? AND shape_id <= ?"
                " ORDER BY shape_id LIMIT ?",
                (last_id, end_id, self.rows_at_once),
            ).fetchall()
            if not rows:
                return
            yield np.array([row[0] for row in rows], np.int64), [row[1] for row in rows]
            last_id = rows[-1][0]


class CodeTables(KindTables):
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
        for table, code in (
            ("codes", signature.code),
            ("local_words", signature.local_code),
            ("view_codes", signature.view_code),
        ):
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
        if not self._has_table(kind):
            return
        with self.explained():
            for shape_ids, blobs in self._blocks(kind).pages(last_id):
                content = b"".join(blobs)
                if len(content) != len(shape_ids) * code_bytes:
                    raise self.damaged("a code has another length than its model's")
                yield shape_ids, np.frombuffer(content, np.uint8).reshape(len(shape_ids), code_bytes)

    def codes(self, kind: CodeKind, shape_ids: Sequence[int], code_bytes: int) -> CodePage:
        """Return ids and codes of some shapes, see `Store.codes`."""
        known = shape_ids if self._has_table(kind) else []
        rows = self.rows_with_ids(f"SELECT shape_id, code FROM {kind} WHERE shape_id", known)
        codes = self.matrix([row[1] for row in rows], np.dtype(np.uint8), code_bytes)
        return np.array([row[0] for row in rows], np.int64), codes

    def nearest_codes(
        self,
        code: NDArray[np.uint8],  # noqa: ARG002
        count: int,  # noqa: ARG002
        among: NDArray[np.int64] | None = None,  # noqa: ARG002
    ) -> NDArray[np.int64] | None:
        """Leave comparing codes to the memory, see `Store.nearest_codes`."""
        return None

    def count(self) -> int:
        """Return the number of shapes, from the smallest table with a row for each of them."""
        return int(self.value("SELECT count(*) FROM codes"))

    def _has_table(self, kind: CodeKind) -> bool:
        return kind != "view_codes" or self.has_kind_tables()

    def _blocks(self, kind: CodeKind) -> CodeBlocks:
        return CodeBlocks(self.connection, kind, self.block_ids, self.rows_at_once)
