# SPDX-License-Identifier: MIT
"""Which local words each shape of a library has, in memory: finds those that share most with a query.

A bit for each shape and word, eight words of all shapes of a block after each other: a query has some
hundreds of the 2,048 words, and only theirs are unpacked. A million shapes take 256 MB.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.search.codes.shape_index import ShapeIndex

__all__ = ["WordIndex"]

# Shapes in a block: their bits of some hundred words, as floats, stay in the processor's cache.
_BLOCK = 4096


class WordIndex(ShapeIndex):
    """Words of shapes by their ids.

    Parameters
    ----------
    code_bytes : int
        Length of each code, see `LocalWords.code`.
    """

    def __init__(self, code_bytes: int) -> None:
        super().__init__()
        self._code_bytes = code_bytes
        self._blocks: list[NDArray[np.uint8]] = []

    def _add_codes(self, codes: NDArray[np.uint8]) -> None:
        start = 0
        while start < len(codes):
            used = (self._count + start) % _BLOCK
            if used == 0:
                self._blocks.append(np.zeros((self._code_bytes, _BLOCK), np.uint8))
            portion = codes[start : start + _BLOCK - used]
            self._blocks[-1][:, used : used + len(portion)] = portion.T
            start += len(portion)

    def nearest(self, weights: NDArray[np.float32], count: int) -> list[NDArray[np.int64]]:
        """Ids of the shapes whose words weigh most, by each of some weightings.

        Parameters
        ----------
        weights : (s, V) array of float32
            What it is worth to have each word, see `LocalWords.query_weights`.
        count : int
            How many are wanted for each; fewer come back when there are fewer shapes.

        Returns
        -------
        shape_ids : list of s arrays (min(count, n),) of int64
            Heaviest first; among equals the lowest id first.
        """
        asked = np.flatnonzero(weights.any(axis=0))
        weights = np.ascontiguousarray(weights[:, asked])
        # As `numpy.packbits` packs them: the first word is the highest bit.
        places, bits = asked // 8, (1 << (7 - asked % 8)).astype(np.uint8)[:, None]
        scores = [weights @ (block[places] & bits > 0).astype(np.float32) for block in self._blocks]
        known = self._count
        found = np.concatenate([*scores, np.empty((len(weights), 0), np.float32)], axis=1)[:, :known]
        found[:, self._gone] = -np.inf
        count = min(count, known - len(self._gone))
        return [self._shape_ids[_heaviest(row, count)] for row in found]


def _heaviest(scores: NDArray[np.float32], count: int) -> NDArray[np.intp]:
    """Positions of the greatest, greatest first; among equals the first one."""
    if count == 0:
        return np.empty(0, np.intp)
    least = np.partition(scores, len(scores) - count)[len(scores) - count]
    chosen = np.flatnonzero(scores >= least)
    return np.asarray(chosen[np.argsort(-scores[chosen], kind="stable")][:count])
