# SPDX-License-Identifier: MIT
"""The Mesh value, and measures and connectivity of meshes."""

from __future__ import annotations

from dataclasses import FrozenInstanceError
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, face_areas, measures, unique_edges
from shapegoogle_core.mesh.connectivity import boundary_vertices, used_vertices
from shapegoogle_core.mesh.measures import vertex_areas, vertex_normals

SQUARE = Mesh([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]], name="square")


def test_arrays_are_copies_that_cannot_be_written_to() -> None:
    vertices = np.zeros((4, 3))
    mesh = Mesh(vertices, [[0, 1, 2]])
    vertices[0] = 1
    assert not mesh.vertices.any()
    for array in (mesh.vertices, mesh.faces):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(FrozenInstanceError):
        mesh.name = "other"  # type: ignore[misc]


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        ([[0, 0], [1, 1]], None, r"'thing': vertices must have shape \(n, 3\), not \(2, 2\)"),
        (np.zeros((4, 3)), np.zeros((2, 4), int), r"'thing': faces must be triangles, shape \(m, 3\)"),
        (np.zeros((4, 3)), np.zeros((2, 3)), "'thing': faces must be integers, not float64"),
        (np.array([[0, 0, np.nan]] * 2 + [[0, 0, 0]]), None, "'thing': 2 of 3 vertices have NaN"),
        (np.array([[0, 0, 0], [0, np.inf, 0]]), None, r"'thing': 1 of 2 vertices have NaN.*first: vertex 1"),
        (
            np.zeros((4, 3)),
            [[0, 1, 4]],
            "'thing': a face names vertex 4, but indices must be 0 to 3",
        ),
        (np.zeros((4, 3)), [[0, 1, -1]], "names vertex -1, but indices must be 0 to 3; subtract 1"),
        (np.zeros((4, 3)), [[0, 1, 2**32]], "'thing': a face names vertex 4294967296"),
    ],
)
def test_arrays_that_are_not_a_mesh(vertices: ArrayLike, faces: ArrayLike | None, words: str) -> None:
    with pytest.raises(MeshError, match=words):
        Mesh(vertices, faces, "thing")


def test_properties() -> None:
    assert (SQUARE.area, SQUARE.extents, SQUARE.is_point_cloud) == (4.0, (2.0, 2.0, 0.0), False)
    assert repr(SQUARE) == "Mesh('square', 4 vertices, 2 faces)"
    cloud = Mesh(SQUARE.vertices)
    assert (cloud.area, cloud.extents, cloud.is_point_cloud, cloud.name) == (
        0.0,
        (2.0, 2.0, 0.0),
        True,
        "mesh",
    )


def test_measures_and_boundary_of_a_square() -> None:
    assert face_areas(SQUARE).tolist() == [2, 2]
    assert vertex_areas(SQUARE) == pytest.approx([4 / 3, 2 / 3, 4 / 3, 2 / 3])
    assert np.array_equal(vertex_normals(SQUARE), np.tile([0, 0, 1], (4, 1)))
    assert boundary_vertices(SQUARE).all()


@given(st.integers(0, 2**32 - 1))
def test_areas_of_vertices_add_up_and_normals_have_unit_length(seed: int) -> None:
    random: Any = np.random.default_rng(seed)
    mesh = Mesh(random.normal(size=(20, 3)), random.integers(0, 20, (30, 3)))
    assert vertex_areas(mesh).sum() == pytest.approx(mesh.area)
    lengths = np.linalg.norm(vertex_normals(mesh), axis=1)
    assert np.allclose(lengths[lengths > 0], 1)


def test_faces_in_blocks_have_the_same_areas_to_the_last_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    mesh = Mesh(rng.normal(size=(50, 3)), rng.integers(0, 50, (100, 3)))
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    expected = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    for faces_at_once in (7, 100, 1000):
        monkeypatch.setattr(measures, "FACES_AT_ONCE", faces_at_once)
        assert np.array_equal(face_areas(mesh), expected)


def test_edges_and_used_vertices_without_sorting() -> None:
    faces = np.random.default_rng(0).integers(3, 40, (30, 3))
    used, renumbered = used_vertices(faces, 50)
    assert np.array_equal(used, np.unique(faces))
    assert np.array_equal(used[renumbered], faces)
    edges, counts = unique_edges(Mesh(np.zeros((50, 3)), faces))
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    expected, expected_counts = np.unique(sides, axis=0, return_counts=True)
    assert np.array_equal(edges, expected)
    assert np.array_equal(counts, expected_counts)
