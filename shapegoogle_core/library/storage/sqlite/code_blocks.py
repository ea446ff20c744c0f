# SPDX-License-Identifier: MIT
"""The codes of a library file once more, packed: a million are read in tens of milliseconds.

Their own rows lie scattered between bags and samples, 90 to a page: reading a million of them takes most of
a second, and from a cold disk one seek for each page. So the codes of every 4,096 ids in a row stand together
in one more row, as soon as all these ids are given; ids are never given twice and codes never change. Only
what came since the last full block is read row by row.

The rows of `codes` are what counts. A trigger drops a block when one of its shapes is removed, also by an
older version of this program, which knows nothing of blocks; what has no block is read row by row. So these
tables are no new format: any library gets them once it is large enough, when a shape is added to it.

`Store` alone uses this module, inside its transactions; errors are those of sqlite3.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

__all__ = ["BLOCK_IDS", "CODE_TABLES", "CodeBlocks", "CodeRows"]

# Ids in a block: a read of some 140 KB for codes of 256 bits, and no more to write when one shape is removed.
BLOCK_IDS = 4_096
# Rows in memory at once as Python objects, which take several times the room of their codes.
ROWS_AT_ONCE = 50_000
# Place of an id within its block.
OFFSET_TYPE = np.dtype("<u2")

CODE_TABLES = {"codes": "code_blocks", "local_words": "local_word_blocks"}
"""Tables of codes, and what their blocks stand in."""

TABLE = "CREATE TABLE {blocks} (block INTEGER PRIMARY KEY, offsets BLOB NOT NULL, codes BLOB NOT NULL)"
TRIGGER = f"""
CREATE TRIGGER {{blocks}}_removed AFTER DELETE ON {{codes}} BEGIN
    DELETE FROM {{blocks}} WHERE block = (old.shape_id - 1) / {BLOCK_IDS};
END
"""

CodeRows = tuple[NDArray[np.int64], list[bytes]]
"""Ids of shapes, and their codes: one string of bytes for each, or one for all."""


class CodeBlocks:
    """The packed codes in an open library file.

    Parameters
    ----------
    connection : sqlite3.Connection
    codes : str
        One of `CODE_TABLES`.
    """

    def __init__(self, connection: sqlite3.Connection, codes: str) -> None:
        self._connection = connection
        self._codes = codes
        self._blocks = CODE_TABLES[codes]

    def exist(self) -> bool:
        """Whether this library is so large that it has blocks."""
        found = self._connection.execute("SELECT 1 FROM sqlite_master WHERE name = ?", (self._blocks,))
        return found.fetchone() is not None

    def pages(self, last_id: int) -> Iterator[CodeRows]:
        """Read all codes after an id, in the order of the ids; to be used up within one transaction.

        Parameters
        ----------
        last_id : int
            0: read all.

        Yields
        ------
        shape_ids : (n,) array of int64
        codes : list of bytes
        """
        blocks: list[int] = []
        if self.exist():
            # Block b holds the ids from b · 4,096 + 1 on; the first one wholly after `last_id`:
            first = -(-last_id // BLOCK_IDS)
            numbers = self._connection.execute(
                f"SELECT block FROM {self._blocks} WHERE block >= ? ORDER BY block", (first,)
            )
            blocks = [number for (number,) in numbers.fetchall()]
        for block in blocks:
            yield from self._rows(last_id, block * BLOCK_IDS)
            offsets, codes = self._connection.execute(
                f"SELECT offsets, codes FROM {self._blocks} WHERE block = ?", (block,)
            ).fetchone()
            yield block * BLOCK_IDS + 1 + np.frombuffer(offsets, OFFSET_TYPE).astype(np.int64), [codes]
            last_id = (block + 1) * BLOCK_IDS
        yield from self._rows(last_id, np.iinfo(np.int64).max)

    def complete(self, shape_id: int) -> None:
        """Pack all that is not packed up to an id with which a block ends; makes the tables at the first one.

        Parameters
        ----------
        shape_id : int
            Of the shape that was just added. Ids that end no block do nothing.
        """
        if shape_id % BLOCK_IDS:
            return
        if not self.exist():
            self._connection.execute(TABLE.format(blocks=self._blocks))
            self._connection.execute(TRIGGER.format(blocks=self._blocks, codes=self._codes))
        packed = {number for (number,) in self._connection.execute(f"SELECT block FROM {self._blocks}")}
        self.pack(sorted(set(range(shape_id // BLOCK_IDS)) - packed))

    def holding(self, where: str, parameters: Iterable[object]) -> set[int]:
        """Find the blocks that hold the codes of some shapes.

        Parameters
        ----------
        where : str
            Condition on the table `shapes`.
        parameters : iterable
            For its question marks.
        """
        if not self.exist():
            return set()
        statement = (
            f"SELECT block FROM {self._blocks} WHERE block IN"
            f" (SELECT (id - 1) / {BLOCK_IDS} FROM shapes WHERE {where})"
        )
        return {number for (number,) in self._connection.execute(statement, tuple(parameters))}

    def pack(self, blocks: Iterable[int]) -> None:
        """Write these blocks anew from the rows of `codes`."""
        for block in blocks:
            first = block * BLOCK_IDS
            rows = list(self._rows(first, first + BLOCK_IDS))
            shape_ids = np.concatenate([np.empty(0, np.int64), *(ids for ids, _ in rows)])
            codes = b"".join(code for _, page in rows for code in page)
            offsets = (shape_ids - first - 1).astype(OFFSET_TYPE).tobytes()
            self._connection.execute(
                f"INSERT OR REPLACE INTO {self._blocks} VALUES (?, ?, ?)", (block, offsets, codes)
            )

    def _rows(self, last_id: int, end_id: int) -> Iterator[CodeRows]:
        """Read single codes: those after one id, up to another one, in pages."""
        while True:
            rows = self._connection.execute(
                f"SELECT shape_id, code FROM {self._codes} WHERE shape_id > ? AND shape_id <= ?"
                " ORDER BY shape_id LIMIT ?",
                (last_id, end_id, ROWS_AT_ONCE),
            ).fetchall()
            if not rows:
                return
            yield np.array([row[0] for row in rows], np.int64), [row[1] for row in rows]
            last_id = rows[-1][0]
