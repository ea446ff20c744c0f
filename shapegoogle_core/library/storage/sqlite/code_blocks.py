# SPDX-License-Identifier: MIT
"""Packed copies of the codes, so that a million of them are read in tens of milliseconds.

The rows of the tables `codes` and `local_words` lie scattered between bags and samples: reading a million of
them takes most of a second, and from a cold disk one seek for each page. So the codes of every 4,096
consecutive ids are also stored together in one row, as soon as all these ids are in use; ids are never given
twice and codes never change. Only codes added since the last full block are read row by row.

The rows count, the blocks are a copy. A trigger drops a block when one of its shapes is removed, and whatever
has no block is read row by row.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.storage.store import CodeKind

__all__ = ["BLOCK_IDS", "CodeBlocks", "CodeRows"]

# A read of some 140 KB for codes of 256 bits, and no more to write when one shape is removed.
BLOCK_IDS = 4_096
# As Python objects rows take several times the room of their codes.
ROWS_AT_ONCE = 50_000
# Place of an id within its block.
OFFSET_TYPE = np.dtype("<u2")

BLOCK_TABLES: dict[CodeKind, str] = {"codes": "code_blocks", "local_words": "local_word_blocks"}

CodeRows = tuple[NDArray[np.int64], list[bytes]]
"""Ids of shapes, and their codes: one string of bytes for each, or one for all."""


@dataclass(frozen=True)
class CodeBlocks:
    """The packed codes of an open library file, for use inside its transactions.

    Attributes
    ----------
    connection : sqlite3.Connection
        Its errors are not translated here.
    kind : {"codes", "local_words"}
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
