# SPDX-License-Identifier: MIT
"""Edges shared by faces, and pairs of vertices in order."""

from __future__ import annotations

import numpy as np
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from shapegoogle_core.mesh import as_mesh
from shapegoogle_core.mesh.connectivity import (
    any_corner,
    edge_graph,
    edge_lengths,
    shared_sides,
    sorted_pairs,
    unique_edges,
    used_points,
)


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


def test_the_graph_of_edges_has_each_edge_once_with_its_length() -> None:
    box = as_mesh(trimesh.creation.box((1, 2, 3)))
    graph = edge_graph(box)
    edges, _ = unique_edges(box)
    assert graph.shape == (8, 8)
    assert graph.nnz == len(edges) == 18
    np.testing.assert_array_equal(graph[edges[:, 0], edges[:, 1]], edge_lengths(box))
