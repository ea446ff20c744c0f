# SPDX-License-Identifier: MIT
"""Closing holes: what is closed, how, and what is left open."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from shapegoogle_core.mesh import Mesh, unique_edges
from shapegoogle_core.preprocessing import close_holes, holes, repair
from shapegoogle_core.preprocessing.holes import boundary_loops

BALL = trimesh.creation.icosphere(subdivisions=4)

Mask = NDArray[np.bool_]


def without(mesh: Mesh, gone: Mask) -> Mesh:
    """The mesh without some vertices."""
    keep = ~np.isin(mesh.faces, np.flatnonzero(gone)).any(axis=1)
    return repair(Mesh(mesh.vertices, mesh.faces[keep]))


def boundary_edges(mesh: Mesh) -> int:
    return int((unique_edges(mesh)[1] == 1).sum())


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def is_oriented(mesh: Mesh) -> bool:
    """No two faces run along an edge in the same direction."""
    half_edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return len(np.unique(half_edges, axis=0)) == len(half_edges)


def caps(*directions: tuple[float, float, float], radius: float) -> Mask:
    inside = [np.linalg.norm(BALL.vertices - direction, axis=1) < radius for direction in directions]
    return np.asarray(np.any(inside, axis=0))


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
def test_small_holes_are_closed(unit: float) -> None:
    open_ball = without(BALL, caps((1, 0, 0), (0, 1, 0), (0, 0, -1), radius=0.3))
    open_ball = Mesh(open_ball.vertices * unit, open_ball.faces, "ball")
    closed = close_holes(open_ball)
    assert boundary_edges(closed) == 0
    assert is_oriented(closed)
    assert closed.name == "ball"
    assert len(closed.vertices) == len(open_ball.vertices) + 3
    assert np.array_equal(closed.faces[: len(open_ball.faces)], open_ball.faces)
    # Each lid cuts off a cap of height about 0.045.
    assert volume(closed) == pytest.approx(4 / 3 * np.pi * unit**3, rel=0.02)


def test_inside_out_surface_stays_inside_out() -> None:
    open_ball = without(BALL, caps((1, 0, 0), radius=0.3))
    closed = close_holes(Mesh(open_ball.vertices, open_ball.faces[:, ::-1]))
    assert boundary_edges(closed) == 0
    assert is_oriented(closed)
    assert volume(closed) < 0


def test_width_decides() -> None:
    open_ball = without(BALL, caps((1, 0, 0), radius=0.3))
    width = 0.6 / float(np.linalg.norm(np.ptp(open_ball.vertices, axis=0)))
    assert boundary_edges(close_holes(open_ball, 1.3 * width)) == 0
    assert close_holes(open_ball, 0.8 * width).faces.shape == open_ball.faces.shape
    assert close_holes(open_ball, 0) is open_ball


def test_missing_triangle_needs_no_vertex() -> None:
    for gone in range(0, len(BALL.faces), 397):
        open_ball = repair(Mesh(BALL.vertices, np.delete(BALL.faces, gone, axis=0)))
        closed = close_holes(open_ball)
        assert len(closed.vertices) == len(BALL.vertices)
        assert boundary_edges(closed) == 0
        assert is_oriented(closed)


def test_holes_that_touch_in_a_vertex() -> None:
    """A figure eight becomes two lids."""
    rim = BALL.vertices - BALL.vertices[0]
    ring = np.flatnonzero(np.linalg.norm(rim, axis=1) < 1e-9)
    neighbours = np.unique(BALL.faces[(BALL.faces == ring[0]).any(axis=1)])
    around = [face for face in range(len(BALL.faces)) if (BALL.faces[face] == ring[0]).any()]
    assert len(neighbours) in (6, 7)
    open_ball = repair(
        Mesh(BALL.vertices, np.delete(BALL.faces, [around[0], _opposite(around, ring[0])], axis=0))
    )
    closed = close_holes(open_ball)
    assert boundary_edges(closed) == 0
    assert is_oriented(closed)
    assert len(closed.faces) == len(BALL.faces)


def _opposite(around: list[int], vertex: int) -> int:
    """Of the faces round a vertex one that shares only that vertex with the first."""
    first = set(BALL.faces[around[0]])
    return next(face for face in around if set(BALL.faces[face]) & first == {vertex})


class TestSheetsStayOpen:
    def test_flat_square(self) -> None:
        square = repair(Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]))
        assert close_holes(square, 10) is square or len(close_holes(square, 10).faces) == 2

    def test_soup_of_sheets(self) -> None:
        """Small leaves in a large tree: width does not tell a leaf from a hole, its outline does."""
        rng = np.random.default_rng(0)
        leaf = np.array([[-1, 0, 0], [0, -0.4, 0.1], [1, 0, 0], [0, 0.4, 0.1]]) * 0.02
        places = rng.uniform(-1, 1, (400, 3))
        vertices = (places[:, None] + leaf).reshape(-1, 3)
        faces = (np.array([[0, 1, 2], [0, 2, 3]]) + 4 * np.arange(400)[:, None, None]).reshape(-1, 3)
        tree = Mesh(vertices, faces)
        assert len(close_holes(tree).faces) == len(faces)

    def test_lone_triangles(self) -> None:
        triangles = np.random.default_rng(0).uniform(0, 1, (50, 3, 3)) * 0.05
        mesh = Mesh(
            (triangles + np.arange(50)[:, None, None] / 50).reshape(-1, 3), np.arange(150).reshape(-1, 3)
        )
        assert len(close_holes(mesh).faces) == 50

    def test_hole_in_a_sheet_is_closed_but_not_its_outline(self) -> None:
        x, y = np.meshgrid(np.linspace(0, 1, 21), np.linspace(0, 1, 21))
        points = np.stack([x.ravel(), y.ravel(), np.zeros(441)], axis=1)
        corner = (np.arange(20)[:, None] * 21 + np.arange(20)).ravel()
        faces = np.concatenate(
            [np.stack([corner, corner + 1, corner + 22], 1), np.stack([corner, corner + 22, corner + 21], 1)]
        )
        sheet = without(Mesh(points, faces), np.linalg.norm(points - [0.5, 0.5, 0], axis=1) < 0.12)
        closed = close_holes(sheet, 10)
        assert boundary_edges(closed) == 80
        assert closed.area == pytest.approx(1)


def test_crack_without_width_has_no_lid() -> None:
    """A T-junction leaves a boundary loop of no area; faces of no area would not help."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, -1, 0], [0.5, 0, 0]])
    faces = [[0, 1, 2], [0, 3, 4], [4, 3, 1]]
    closed = close_holes(Mesh(vertices, faces), 10)
    assert closed.area == pytest.approx(Mesh(vertices, faces).area)


def test_non_manifold_edges_do_no_harm() -> None:
    """Three sheets on one edge, and boundaries that end there."""
    vertices = [[0, 0, 0], [0, 0, 1], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]]
    fins = Mesh(vertices, [[0, 1, 2], [0, 1, 3], [1, 0, 4]])
    assert len(close_holes(fins, 10).vertices) <= 7


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.tuples(*[st.integers(0, 11)] * 3).filter(lambda f: len(set(f)) == 3), min_size=1, max_size=40)
)
def test_any_garbage(faces: list[tuple[int, ...]]) -> None:
    """Random faces on an icosahedron's vertices: never a crash, old faces stay, no edge gets worse."""
    corners = trimesh.creation.icosahedron().vertices
    mesh = repair(Mesh(corners, faces))
    closed = close_holes(mesh, 10)
    assert np.array_equal(closed.faces[: len(mesh.faces)], mesh.faces)
    assert boundary_edges(closed) <= boundary_edges(mesh)
    new = closed.faces[len(mesh.faces) :]
    edges, counts = unique_edges(closed)
    old = {tuple(edge) for edge in unique_edges(mesh)[0][unique_edges(mesh)[1] > 1].tolist()}
    touched = {
        tuple(sorted((face[i], face[j]))) for face in new.tolist() for i, j in ((0, 1), (1, 2), (2, 0))
    }
    assert not touched & old
    for edge, count in zip(edges.tolist(), counts.tolist(), strict=True):
        if tuple(edge) in touched:
            assert count == 2


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)).filter(lambda e: e[0] != e[1]), max_size=40))
def test_loops_are_simple_and_disjoint(edges: list[tuple[int, int]]) -> None:
    unique = sorted({tuple(sorted(edge)) for edge in edges})
    loops = boundary_loops(np.array(unique, np.int64).reshape(-1, 2))
    used = [edge for loop in loops for edge in loop]
    assert len(used) == len(set(used))
    for loop in loops:
        degree = np.bincount(np.array(unique)[loop].ravel())
        assert set(degree.tolist()) <= {0, 2}
        assert (degree == 2).sum() == len(loop)
    # Where an even number of edges meet everywhere, none is left over.
    if not (np.bincount(np.array(unique, int).ravel(), minlength=1) % 2).any():
        assert len(used) == len(unique)


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)).filter(lambda e: e[0] != e[1]), max_size=12),
    st.lists(st.integers(2, 6), max_size=4),
    st.integers(0, 2**32 - 1),
)
def test_loops_that_no_other_edge_meets_are_found_as_all_others(
    tangle: list[tuple[int, int]], sizes: list[int], seed: int
) -> None:
    cycles = [[(i, (i + 1) % size) for i in range(size)] for size in sizes]
    apart = [(20 + 10 * n + a, 20 + 10 * n + b) for n, cycle in enumerate(cycles) for a, b in cycle]
    edges = np.array(sorted({*tangle, *apart}), np.int64).reshape(-1, 2)
    edges = np.random.default_rng(seed).permutation(edges)
    loops = boundary_loops(edges)
    with mock.patch.object(holes, "_plain_loop", return_value=[]):
        assert boundary_loops(edges) == loops
