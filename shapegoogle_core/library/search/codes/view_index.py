# SPDX-License-Identifier: MIT
"""Codes of the views of a library in memory: finds the shapes that look most alike.

The first half of a code is that of the straight pose, the second that of the principal axes. A query has
several codes for each half, one for each way to turn it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.search.codes.hamming import (
    Words,
    hamming_distances,
    nearest_by_distance,
    pack_words,
)
from shapegoogle_core.library.search.codes.packed_index import PackedIndex

__all__ = ["ViewIndex"]


class ViewIndex(PackedIndex):
    """Codes of views by the ids of their shapes; see `PackedIndex`."""

    def nearest(
        self,
        alternatives: Sequence[NDArray[np.uint8]],
        count: int,
        among: NDArray[np.int64] | None = None,
    ) -> NDArray[np.int64]:
        """Find the shapes one of whose halves differs least from one of the query's codes.

        Parameters
        ----------
        alternatives : sequence of (a, code_bytes) array of uint8
            Codes of the query for each portion of the stored codes, see `ViewModel.code_alternatives`.
        count : int
            Number of shapes to find; fewer come back when there are fewer.
        among : (m,) array of int64, optional
            Ids of the shapes to choose from; all shapes by default.

        Returns
        -------
        shape_ids : (min(count, n),) array of int64
            Nearest first; among equals the lowest id first.
        """
        queries = [pack_words(codes) for codes in alternatives]
        if among is not None:
            chosen = self._positions(among)
            return self._shape_ids[
                chosen[nearest_by_distance([self._distances(self._at(chosen), queries)], count)]
            ]
        blocks = (self._distances(block, queries) for block in self._filled())
        positions = nearest_by_distance(blocks, count + len(self._gone))
        return self._best_there(positions, count)

    def _distances(self, words: Words, queries: Sequence[Words]) -> NDArray[np.uint16]:
        least = np.full(words.shape[1], np.iinfo(np.uint16).max, np.uint16)
        start = 0
        for codes in queries:
            portion = words[start : start + len(codes)]
            for query in codes.T if words.shape[1] else ():
                np.minimum(least, hamming_distances(portion, query, self._counter), out=least)
            start += len(codes)
        return least
