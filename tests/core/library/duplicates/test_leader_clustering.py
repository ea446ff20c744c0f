# SPDX-License-Identifier: MIT
"""Keys find almost every pair that comparing all shapes would find."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from shapegoogle_core.library.duplicates.leader_clustering import (
    Banding,
    choose_banding,
    cluster_by_leaders,
)
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import row_distances


def test_keys_find_what_comparing_all_finds() -> None:
    """Planted pairs at all angles up to the limit, among strangers."""
    random = np.random.default_rng(0)
    count, limit = 3000, 0.04
    vectors = random.standard_normal((count, 60)).astype(np.float32)
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    angles = random.uniform(0, np.arccos(1 - limit), count // 2)[:, None]
    turned = random.standard_normal((count // 2, 60))
    turned -= (turned * vectors[: count // 2]).sum(axis=1, keepdims=True) * vectors[: count // 2]
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    vectors[count // 2 :] = np.cos(angles) * vectors[: count // 2] + np.sin(angles) * turned
    codes = np.packbits(vectors @ random.standard_normal((60, 256)) > 0, axis=1)

    def distances(position: int, others: NDArray[np.int64]) -> FloatArray:
        return row_distances("cosine", vectors[position][None], vectors[others])

    banding = choose_banding(count, np.arccos(1 - limit) / np.pi, 256)
    clusters = cluster_by_leaders(codes, distances, limit, banding)
    found = np.mean(clusters.leader[count // 2 :] == np.arange(count // 2))
    assert found > 0.985
    assert clusters.compared < count * count / 20


@settings(deadline=None, max_examples=50)
@given(
    points=st.lists(st.floats(0, 10), max_size=30),
    limit=st.floats(0, 5),
)
def test_members_are_near_an_earlier_leader(points: list[float], limit: float) -> None:
    """With one key for all, every leader is compared: what leads has no earlier leader nearby."""
    x = np.array(points)

    def distances(position: int, others: NDArray[np.int64]) -> FloatArray:
        return np.asarray(np.abs(x[others] - x[position]))

    codes = np.zeros((len(x), 1), np.uint8)
    clusters = cluster_by_leaders(codes, distances, limit, Banding(8, 1))
    leaders = clusters.leaders()
    for position, leader in enumerate(clusters.leader.tolist()):
        earlier = leaders[leaders < position]
        nearby = earlier[np.abs(x[earlier] - x[position]) <= limit]
        assert leader in leaders
        assert (leader == position) == (len(nearby) == 0)
        assert clusters.distance[position] == abs(x[leader] - x[position])
        if len(nearby):
            assert clusters.distance[position] == np.abs(x[nearby] - x[position]).min()
    grouped = [position for group in clusters.groups() for position in group.tolist()]
    assert len(grouped) == len(set(grouped))
    assert set(range(len(x))) - set(grouped) <= set(leaders.tolist())


def test_recall_of_keys_is_that_of_chance() -> None:
    assert Banding(key_bits=2, keys=2).recall(0.5) == pytest.approx(1 - (1 - 0.25) ** 2)
