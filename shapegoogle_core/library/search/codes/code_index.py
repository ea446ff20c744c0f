# SPDX-License-Identifier: MIT
"""Codes of a library in memory: finds the nearest (algorithm 2 of the paper)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.search.codes.hamming import nearest_codes, nearest_in_blocks, pack_words
from shapegoogle_core.library.search.codes.packed_index import PackedIndex

__all__ = ["CodeIndex"]


class CodeIndex(PackedIndex):
    """Codes of shapes by their ids; see `PackedIndex`."""

    def nearest(
        self, code: NDArray[np.uint8], count: int, among: NDArray[np.int64] | None = None
    ) -> NDArray[np.int64]:
        """Find the shapes whose codes are nearest to one.

        Parameters
        ----------
        code : (code_bytes,) array of uint8
        count : int
            Number of shapes to find; fewer come back when there are fewer.
        among : (m,) array of int64, optional
            Ids of the shapes to choose from; all shapes by default.

        Returns
        -------
        shape_ids : (min(count, n),) array of int64
            Nearest first; among equals the lowest id first.
        """
        query = pack_words(code[None])[:, 0]
        if among is not None:
            chosen = self._positions(among)
            return self._shape_ids[chosen[nearest_codes(self._at(chosen), query, count, self._counter)]]
        positions = nearest_in_blocks(self._filled(), query, count + len(self._gone), self._counter)
        return self._best_there(positions, count)
