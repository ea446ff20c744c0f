# SPDX-License-Identifier: MIT
"""Binary codes of a library in memory, packed into words that are compared by counting bits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.search.codes.hamming import BLOCK, BitCounter, Words, count_bits, pack_words
from shapegoogle_core.library.search.codes.shape_index import ShapeIndex

__all__ = ["PackedIndex"]


class PackedIndex(ShapeIndex):
    """Binary codes of shapes by their ids.

    Parameters
    ----------
    counter : callable, optional
        Function that counts the set bits of an array of words.
    block : int, optional
        Number of shapes in a block.
    """

    def __init__(self, counter: BitCounter = count_bits, block: int = BLOCK) -> None:
        super().__init__(block)
        self._counter = counter

    def _columns(self, codes: NDArray[np.uint8]) -> Words:
        return pack_words(codes)

    def _best_there(self, positions: NDArray[np.intp], count: int) -> NDArray[np.int64]:
        """Return the ids of the first `count` positions whose shapes are not gone."""
        if len(self._gone):
            positions = positions[~np.isin(positions, self._gone)][:count]
        return self._shape_ids[positions]
