# SPDX-License-Identifier: MIT
"""Edges shared by faces, and pairs of vertices in order."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from shapegoogle_core.mesh.connectivity import any_corner, shared_sides, sorted_pairs, used_points


@given(st.integers(0, 1_000), st.sampled_from([0, 1, 200, 10_000]), st.integers(1, 300))
def test_pairs_are_in_the_order_of_a_stable_sort(seed: int, length: int, count: int) -> None:
    first, second = np.random.default_rng(seed).integers(0, count, (2, length), np.int32)
    assert sorted_pairs(first, second, count).tolist() == np.lexsort((second, first)).tolist()


def test_sides_on_one_edge_are_found_whatever_their_directions() -> None:
    # Three faces share the edge between 0 and 1, two of them in one direction; two share that of 1 and 2.
    faces = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4], [5, 2, 1]])
    one, other = shared_sides(faces, 6)
    assert list(zip(one.tolist(), other.tolist(), strict=True)) == [(0, 3), (3, 6), (1, 10)]


def test_points_that_no_face_uses_are_left_out() -> None:
    corners = np.arange(12.0).reshape(4, 3)
    assert used_points(corners, np.array([[0, 3, 1]])).tolist() == corners[[0, 1, 3]].tolist()
    assert used_points(corners, np.empty((0, 3), int)).tolist() == corners.tolist()


def test_rows_with_any_marked_vertex() -> None:
    marked = np.array([False, True, False, False])
    assert any_corner(marked, np.array([[0, 1, 2], [0, 2, 3], [3, 2, 1]])).tolist() == [True, False, True]
    assert any_corner(marked, np.array([[0, 2], [3, 1]])).tolist() == [False, True]
