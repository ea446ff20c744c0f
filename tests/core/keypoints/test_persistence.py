# SPDX-License-Identifier: MIT
"""Persistence of maxima, by hand and against counting islands."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.keypoints import persistent_maxima


def path(count: int) -> np.ndarray:
    """Edges of vertices in a row."""
    return np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)


class TestPersistence:
    def test_of_a_range_known_by_hand(self) -> None:
        # 3 meets 5 at 1, 4 meets 5 at 2.5, 2 meets 5 at 0.5. The lowest point is 0.
        heights = np.array([0, 3, 1, 5, 2.5, 4, 0.5, 2, 0.25])
        maxima, deaths = persistent_maxima(heights, path(9))
        assert maxima.tolist() == [3, 5, 1, 7]
        assert deaths.tolist() == [0, 2.5, 1, 0.5]

    def test_the_elder_survives_on_a_ring(self) -> None:
        ring = np.concatenate([path(6), [[5, 0]]])
        maxima, deaths = persistent_maxima(np.array([4.0, 1, 3, 0, 2, 1.5]), ring)
        assert (maxima.tolist(), deaths.tolist()) == ([0, 2, 4], [0, 1, 1.5])

    def test_of_equal_heights_the_smaller_index_counts_as_higher(self) -> None:
        maxima, deaths = persistent_maxima(np.array([1.0, 1, 0, 1, 1]), path(5))
        assert (maxima.tolist(), deaths.tolist()) == ([0, 3], [0, 0])

    def test_parts_have_a_highest_each(self) -> None:
        maxima, deaths = persistent_maxima(np.array([5.0, 4, 1, 2, 7]), np.array([[0, 1], [2, 3]]))
        assert (maxima.tolist(), deaths.tolist()) == ([4, 0, 3], [7, 4, 1])

    @settings(max_examples=60, deadline=None)
    @given(st.integers(0, 2**32 - 1))
    def test_islands_of_one_level_that_are_left_at_another(self, seed: int) -> None:
        """The numbers of such islands, for all pairs of levels, are all that persistence can say."""
        random = np.random.default_rng(seed)
        n = 12
        heights = random.permutation(n).astype(float)
        edges = random.integers(0, n, (14, 2))
        maxima, deaths = persistent_maxima(heights, edges[edges[:, 0] != edges[:, 1]])
        births = heights[maxima]
        _, part = _islands(np.ones(n, bool), edges)
        for_ever = np.array([heights[m] == heights[part == part[m]].max() for m in maxima])
        deaths = np.where(for_ever, -1, deaths)
        for low in range(n):
            above, island = _islands(heights >= low, edges)
            for high in range(low, n):
                left = len(set(island[above & (heights >= high)]))
                assert left == ((births >= high) & (deaths < low)).sum()


def _islands(above: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    kept = edges[above[edges].all(axis=1)]
    graph = sparse.coo_array((np.ones(len(kept)), kept.T), shape=(len(above), len(above)))
    return above, connected_components(graph, directed=False)[1]
