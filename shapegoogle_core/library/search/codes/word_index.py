# SPDX-License-Identifier: MIT
"""Local words of all shapes of a library in memory: finds the shapes that share most of them with a query.

Each shape has one bit per word; eight words of all shapes of a block lie next to each other. A query has some
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
    """Local words of shapes by their ids.

    Parameters
    ----------
    block : int, optional
        Number of shapes in a block.
    """

    def __init__(self, block: int = _BLOCK) -> None:
        super().__init__(block)

    def _columns(self, codes: NDArray[np.uint8]) -> NDArray[np.uint8]:
        return codes.T

    def nearest(
        self, weights: NDArray[np.float32], count: int, among: NDArray[np.int64] | None = None
    ) -> list[NDArray[np.int64]]:
        """Find the shapes whose words weigh most, for each of several weightings.

        Parameters
        ----------
        weights : (s, V) array of float32
            Weight of each word, see `LocalWords.query_weights`.
        count : int
            Number of shapes for each weighting; fewer come back when there are fewer.
        among : (m,) array of int64, optional
            Ids of the shapes to choose from; all shapes by default.

        Returns
        -------
        shape_ids : list of s arrays (min(count, n),) of int64
            Heaviest first; among equals the lowest id first.
        """
        asked = np.flatnonzero(weights.any(axis=0))
        weights = np.ascontiguousarray(weights[:, asked])
        # In the order of `numpy.packbits`: the first word is the highest bit.
        places, bits = asked // 8, (1 << (7 - asked % 8)).astype(np.uint8)[:, None]
        scores = [weights @ (block[places] & bits > 0).astype(np.float32) for block in self._blocks]
        found = np.concatenate([*scores, np.empty((len(weights), 0), np.float32)], axis=1)[:, : self._count]
        skipped = np.zeros(self._count, bool) if among is None else np.ones(self._count, bool)
        if among is not None:
            skipped[self._positions(among)] = False
        skipped[self._gone] = True
        found[:, skipped] = -np.inf
        count = min(count, int(np.count_nonzero(~skipped)))
        return [self._shape_ids[_heaviest(row, count)] for row in found]


def _heaviest(scores: NDArray[np.float32], count: int) -> NDArray[np.intp]:
    """Positions of the greatest scores, greatest first; among equals the first one."""
    if count == 0:
        return np.empty(0, np.intp)
    least = np.partition(scores, len(scores) - count)[len(scores) - count]
    chosen = np.flatnonzero(scores >= least)
    return np.asarray(chosen[np.argsort(-scores[chosen], kind="stable")][:count])
