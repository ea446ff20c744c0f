# SPDX-License-Identifier: MIT
"""All codes of a library in memory: grows with the library, finds the nearest (algorithm 2)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.search.codes.hamming import (
    BLOCK,
    BitCounter,
    Words,
    count_bits,
    nearest_in_blocks,
    pack_words,
)
from shapegoogle_core.library.search.codes.shape_index import ShapeIndex

__all__ = ["CODE_TABLES", "CodeIndex", "CodeTable", "FaissTable", "WordTable", "best_table"]

# From so many codes on faiss is used where it is installed. A search of a million codes of 256 bits then
# takes 1.3 ms instead of 4; of fewer the gain is too small to pay for loading faiss, some 40 ms.
FAISS_FROM = 200_000


class CodeTable(Protocol):
    """Codes in the order in which they were added."""

    def add(self, codes: NDArray[np.uint8]) -> None:
        """Append codes (n, bytes)."""

    def nearest(self, code: NDArray[np.uint8], count: int) -> NDArray[np.intp]:
        """Positions of the `count` nearest, nearest first; among equals the one that was added first."""


class WordTable:
    """Codes as numpy compares them, in blocks: adding one moves none of the others.

    Parameters
    ----------
    code_bytes : int
        Length of each code.
    counter : callable, optional
        What counts the set bits of an array of words.
    """

    def __init__(self, code_bytes: int, counter: BitCounter = count_bits) -> None:
        self._words_per_code = -(-code_bytes // 8)
        self._counter = counter
        self._blocks: list[Words] = []
        self._count = 0

    def add(self, codes: NDArray[np.uint8]) -> None:
        """Append codes (n, bytes)."""
        start = 0
        while start < len(codes):
            used = self._count % BLOCK
            if used == 0:
                self._blocks.append(np.empty((self._words_per_code, BLOCK), np.uint64))
            portion = codes[start : start + BLOCK - used]
            self._blocks[-1][:, used : used + len(portion)] = pack_words(portion)
            self._count += len(portion)
            start += len(portion)

    def nearest(self, code: NDArray[np.uint8], count: int) -> NDArray[np.intp]:
        """Positions of the `count` nearest, nearest first; among equals the one that was added first."""
        # Of the last block only what is filled.
        filled = (block[:, : self._count - BLOCK * index] for index, block in enumerate(self._blocks))
        return nearest_in_blocks(filled, pack_words(code[None])[:, 0], count, self._counter)


class FaissTable:
    """Codes as faiss compares them: ``IndexBinaryFlat``, exact too, and about three times as fast as numpy.

    Parameters
    ----------
    code_bytes : int
        Length of each code.
    """

    def __init__(self, code_bytes: int) -> None:
        import faiss

        self._faiss = faiss
        self._index = faiss.IndexBinaryFlat(8 * code_bytes)

    def add(self, codes: NDArray[np.uint8]) -> None:
        """Append codes (n, bytes)."""
        self._index.add(np.ascontiguousarray(codes))

    def nearest(self, code: NDArray[np.uint8], count: int) -> NDArray[np.intp]:
        """Positions of the `count` nearest, nearest first; among equals the one that was added first."""
        count = min(count, self._index.ntotal)
        if count == 0:
            return np.empty(0, np.intp)
        # Of equals at the end faiss keeps those that were added first, for its heap orders by distance and
        # position; in which order they come it does not promise.
        threads = self._faiss.omp_get_max_threads()
        # One query is work for one thread; others would only wait for it, busily, for 20 ms.
        self._faiss.omp_set_num_threads(1)
        try:
            distances, positions = self._index.search(np.ascontiguousarray(code[None]), count)
        finally:
            self._faiss.omp_set_num_threads(threads)
        return np.asarray(positions[0][np.lexsort((positions[0], distances[0]))], np.intp)


CODE_TABLES: dict[str, Callable[[int], CodeTable]] = {"numpy": WordTable, "faiss": FaissTable}
"""What compares the codes, by name. All find the same."""


def best_table(count: int) -> str:
    """Name the fastest of `CODE_TABLES` for so many codes, of those that are installed."""
    if count < FAISS_FROM:
        return "numpy"
    try:
        import faiss
    except ImportError:
        return "numpy"
    # A folder that happens to have this name can be imported too.
    return "faiss" if hasattr(faiss, "IndexBinaryFlat") else "numpy"


class CodeIndex(ShapeIndex):
    """Codes of shapes by their ids.

    Parameters
    ----------
    code_bytes : int
        Length of each code.
    table : str
        One of `CODE_TABLES`.
    """

    def __init__(self, code_bytes: int, table: str = "numpy") -> None:
        super().__init__()
        self._table = CODE_TABLES[table](code_bytes)

    def _add_codes(self, codes: NDArray[np.uint8]) -> None:
        self._table.add(codes)

    def nearest(self, code: NDArray[np.uint8], count: int) -> NDArray[np.int64]:
        """Ids of the shapes whose codes are nearest to one.

        Parameters
        ----------
        code : (code_bytes,) array of uint8
        count : int
            How many are wanted; fewer come back when there are fewer shapes.

        Returns
        -------
        shape_ids : (min(count, n),) array of int64
            Nearest first; among equals the lowest id first.
        """
        positions = self._table.nearest(code, count + len(self._gone))
        if len(self._gone):
            positions = positions[~np.isin(positions, self._gone)][:count]
        return self._shape_ids[positions]
