# SPDX-License-Identifier: MIT
"""Resampling: the number of vertices changes, the surface does not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from shapegoogle_core.mesh import Mesh, face_areas, unique_edges
from shapegoogle_core.preprocessing import repair, resample, resampling
from shapegoogle_core.preprocessing.resampling import cell_numbers, finest_cell, simplify, thin
from shapegoogle_core.preprocessing.subdivision import subdivide

BALL = trimesh.creation.icosphere(subdivisions=5)
BOX = trimesh.creation.box((1, 2, 3))
PLANK = trimesh.creation.box((1, 0.05, 0.01))


def mesh_of(shape: trimesh.Trimesh, unit: float = 1.0, offset: float = 0.0) -> Mesh:
    return Mesh(np.asarray(shape.vertices) * unit + offset, shape.faces, "shape")


def is_closed_manifold(mesh: Mesh) -> bool:
    return bool((unique_edges(mesh)[1] == 2).all())


def is_oriented(mesh: Mesh) -> bool:
    half_edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return len(np.unique(half_edges, axis=0)) == len(half_edges)


def part_count(mesh: Mesh) -> int:
    return len(trimesh.graph.connected_components(mesh.faces[:, [0, 1, 1, 2]].reshape(-1, 2)))


def bumpy_ball() -> Mesh:
    x, y, z = BALL.vertices.T
    return Mesh(BALL.vertices * (1 + 0.2 * np.sin(5 * x) * np.cos(4 * y + z))[:, None], BALL.faces, "shape")


class TestSubdivide:
    @pytest.mark.parametrize(
        "shape", [BOX, PLANK, trimesh.creation.icosahedron(), trimesh.creation.cone(1, 9)]
    )
    @pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
    def test_surface_stays_and_stays_connected(self, shape: trimesh.Trimesh, unit: float) -> None:
        before = mesh_of(shape, unit)
        after = subdivide(before, 1000)
        assert 1000 <= len(after.vertices) < 4000
        assert after.area == pytest.approx(before.area, rel=1e-12)
        assert is_closed_manifold(after)
        assert is_oriented(after)
        assert np.array_equal(after.vertices[: len(before.vertices)], before.vertices)
        assert after.name == "shape"
        closest_point: Any = trimesh.proximity.closest_point_naive
        _, distance, _ = closest_point(shape, after.vertices[-200:] / unit)
        assert distance.max() < 1e-9

    def test_enough_vertices_are_left_alone(self) -> None:
        mesh = mesh_of(BALL)
        assert subdivide(mesh, 1000) is mesh

    def test_exact_count_where_no_two_edges_are_equal(self) -> None:
        rng = np.random.default_rng(0)
        ball = trimesh.creation.icosphere(subdivisions=2)
        mesh = Mesh(ball.vertices + rng.normal(size=ball.vertices.shape) * 0.02, ball.faces)
        assert len(subdivide(mesh, 1234).vertices) == 1234

    def test_long_thin_faces_become_even(self) -> None:
        after = subdivide(mesh_of(PLANK), 2000)
        sides = after.vertices[after.faces]
        longest = np.linalg.norm(sides - np.roll(sides, 1, axis=1), axis=2).max(axis=1)
        assert longest.max() < 0.03
        aspect = longest**2 / face_areas(after)  # 2.3 for an equilateral triangle, 10 to 200 before
        assert np.median(aspect) < 5
        assert np.quantile(aspect, 0.95) < 10

    def test_turned_shape_is_split_alike(self) -> None:
        """Edges of equal length are split together, whatever rounding says about them."""
        turn = trimesh.transformations.random_rotation_matrix(np.array([0.1, 0.5, 0.9]))[:3, :3]
        straight = subdivide(mesh_of(BOX), 1000)
        turned = subdivide(Mesh(BOX.vertices @ turn.T, BOX.faces), 1000)
        assert len(turned.vertices) == len(straight.vertices)
        distance, _ = cKDTree(straight.vertices @ turn.T).query(turned.vertices)
        assert np.max(distance) < 1e-12

    @settings(max_examples=100, deadline=None)
    @given(
        st.lists(
            st.tuples(*[st.integers(0, 11)] * 3).filter(lambda f: len(set(f)) == 3), min_size=1, max_size=30
        ),
        st.integers(0, 300),
    )
    def test_any_faces(self, faces: list[tuple[int, ...]], floor: int) -> None:
        """Open, non-manifold, several parts: area, boundary and non-manifold edges stay what they were."""
        mesh = repair(Mesh(trimesh.creation.icosahedron().vertices, faces))
        after = subdivide(mesh, floor)
        assert len(after.vertices) >= floor
        assert after.area == pytest.approx(mesh.area)
        before_lengths, lengths = _length_by_face_count(mesh), _length_by_face_count(after)
        for count in {1, *before_lengths} - {2}:  # inner edges are added, no others
            assert lengths.get(count, 0.0) == pytest.approx(before_lengths.get(count, 0.0), abs=1e-9)
        assert lengths.keys() <= before_lengths.keys() | {2}


def _length_by_face_count(mesh: Mesh) -> dict[int, float]:
    edges, counts = unique_edges(mesh)
    length = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    return {int(count): float(length[counts == count].sum()) for count in np.unique(counts)}


class TestSimplify:
    @pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
    @pytest.mark.parametrize("offset", [0.0, 1e3])
    def test_closed_surface(self, unit: float, offset: float) -> None:
        before = bumpy_ball()
        before = Mesh((before.vertices + offset) * unit, before.faces, "shape")
        after = simplify(before, 2000)
        assert 1900 <= len(after.vertices) <= 2000
        assert is_closed_manifold(after)
        assert is_oriented(after)
        assert after.area == pytest.approx(before.area, rel=0.01)
        assert after.name == "shape"

    def test_units_do_not_matter(self) -> None:
        """Powers of two change no digit, so the result has to be the same."""
        before = bumpy_ball()
        after = simplify(before, 1000)
        for unit in (2.0**-20, 2.0**20):
            other = simplify(Mesh(before.vertices * unit, before.faces), 1000)
            assert np.allclose(other.vertices / unit, after.vertices, atol=1e-9)
            assert np.array_equal(other.faces, after.faces)

    def test_sheet_keeps_its_outline(self) -> None:
        x, y = np.meshgrid(np.linspace(0, 1, 101), np.linspace(0, 1, 101))
        points = np.stack([x.ravel(), y.ravel(), 0.05 * np.sin(9 * x.ravel())], axis=1)
        corner = (np.arange(100)[:, None] * 101 + np.arange(100)).ravel()
        faces = np.concatenate(
            [
                np.stack([corner, corner + 1, corner + 102], 1),
                np.stack([corner, corner + 102, corner + 101], 1),
            ]
        )
        before = Mesh(points, faces)
        after = simplify(before, 3000)
        assert len(after.vertices) <= 3000
        assert after.area == pytest.approx(before.area, rel=0.01)

    def test_soup_becomes_a_connected_surface(self) -> None:
        """The faces of a sphere pulled apart: sixty thousand vertices, no edge with two faces."""
        ball = trimesh.creation.icosphere(subdivisions=5)
        gap = np.random.default_rng(0).normal(size=(len(ball.faces), 1, 3)) * 1e-3
        before = Mesh(
            (ball.vertices[ball.faces] + gap).reshape(-1, 3), np.arange(ball.faces.size).reshape(-1, 3)
        )
        assert part_count(before) == len(ball.faces)
        after = simplify(before, 5000)
        assert 4500 <= len(after.vertices) <= 5000
        assert after.area == pytest.approx(before.area, rel=0.1)
        assert part_count(after) == 1
        assert np.isin(after.vertices, before.vertices).all()

    @pytest.mark.parametrize("side", [2, 4])
    def test_sheets_that_cannot_be_collapsed_are_known_by_their_outlines(
        self, monkeypatch: pytest.MonkeyPatch, side: int
    ) -> None:
        """Four hundred bumpy sheets; that their outlines stay is found without collapsing them."""
        row = np.linspace(0, 0.02, side + 1)
        points = np.stack(np.meshgrid(row, row, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
        corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
        a, b, c, d = corner, corner + side + 1, corner + side + 2, corner + 1
        sheet = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
        random = np.random.default_rng(side)
        vertices = random.uniform(-1, 1, (400, 1, 3)) + points + random.normal(0, 1e-3, (400, len(points), 3))
        faces = len(points) * np.arange(400)[:, None, None] + sheet
        mesh = repair(Mesh(vertices.reshape(-1, 3), faces.reshape(-1, 3)))
        budget = int(0.9 * 400 * 4 * side)
        found = simplify(mesh, budget)
        monkeypatch.setattr(resampling, "boundary_vertices", lambda mesh: np.zeros(len(mesh.vertices), bool))
        collapsed = simplify(mesh, budget)
        assert np.array_equal(found.vertices, collapsed.vertices)
        assert np.array_equal(found.faces, collapsed.faces)

    def test_many_parts_keep_their_area(self) -> None:
        """A floor of 1,600 tiles: collapsing edges reaches the budget, but at the cost of whole tiles."""
        tile = trimesh.creation.box((0.999, 0.999, 0.1))
        places = np.stack(np.meshgrid(np.arange(40), np.arange(40), [0.0]), axis=-1).reshape(-1, 1, 3)
        vertices = (places + tile.vertices).reshape(-1, 3)
        faces = (len(tile.vertices) * np.arange(1600)[:, None, None] + tile.faces).reshape(-1, 3)
        before = Mesh(vertices, faces)
        after = simplify(before, 4000)
        assert len(after.vertices) <= 4000
        assert after.area == pytest.approx(before.area, rel=0.1)
        assert part_count(after) < 50

    def test_scattered_leaves(self) -> None:
        """Ten thousand of them cannot be had with five thousand vertices: the budget counts more."""
        rng = np.random.default_rng(0)
        leaf = np.array([[-1, 0, 0], [0, -0.4, 0.1], [1, 0, 0], [0, 0.4, 0.1]]) * 0.005
        vertices = (rng.uniform(-1, 1, (10_000, 1, 3)) + leaf).reshape(-1, 3)
        faces = (np.array([[0, 1, 2], [0, 2, 3]]) + 4 * np.arange(10_000)[:, None, None]).reshape(-1, 3)
        after = simplify(Mesh(vertices, faces), 5000)
        assert 4500 <= len(after.vertices) <= 5000

    @settings(max_examples=100, deadline=None)
    @given(st.integers(0, 2**32 - 1), st.integers(5, 60), st.integers(1, 150), st.integers(4, 40))
    @example(100, 23, 23, 4)  # no grid leaves a face
    def test_budget_holds_for_any_faces(
        self, seed: int, vertex_count: int, face_count: int, budget: int
    ) -> None:
        rng = np.random.default_rng(seed)
        faces = rng.integers(0, vertex_count, (face_count, 3))
        mesh = repair(Mesh(rng.normal(size=(vertex_count, 3)), faces))
        assume(not mesh.is_point_cloud)
        assert len(resample(mesh, floor=4, budget=budget).vertices) <= budget

    def test_noisy_surface(self) -> None:
        before = bumpy_ball()
        rng = np.random.default_rng(0)
        noisy = Mesh(before.vertices + rng.normal(size=before.vertices.shape) * 0.01, before.faces)
        after = simplify(noisy, 2000)
        assert len(after.vertices) <= 2000
        assert before.area < after.area < noisy.area


class TestResample:
    def test_between_floor_and_budget_nothing_happens(self) -> None:
        mesh = mesh_of(BALL)
        assert resample(mesh, 1000, 20_000) is mesh

    def test_both_ends(self) -> None:
        assert len(resample(mesh_of(BALL), 100, 3000).vertices) <= 3000
        assert len(resample(mesh_of(BOX), 100, 3000).vertices) >= 100

    def test_budget_holds_where_subdividing_overshoots(self) -> None:
        """Edges of one length are split together: a sphere's 2,562 vertices become 10,242."""
        ball = trimesh.creation.icosphere(subdivisions=4)
        assert len(subdivide(mesh_of(ball), 5000).vertices) > 5000
        after = resample(mesh_of(ball), 5000, 5000)
        assert 4900 < len(after.vertices) <= 5000
        assert is_closed_manifold(after)

    @pytest.mark.parametrize("soup", [False, True])
    def test_deterministic(self, soup: bool) -> None:
        mesh = bumpy_ball()
        if soup:
            mesh = Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size).reshape(-1, 3))
        first, second = (resample(mesh, 1000, 2500) for _ in range(2))
        assert len(first.vertices) <= 2500
        assert np.array_equal(first.vertices, second.vertices)
        assert np.array_equal(first.faces, second.faces)


@given(st.integers(0, 2**32 - 1), st.floats(1e-3, 10))
def test_points_have_one_number_exactly_if_they_share_a_cell(seed: int, cell: float) -> None:
    position = np.random.default_rng(seed).random((100, 3))
    numbers = cell_numbers(position, cell)
    cells = np.floor(position / cell)
    assert np.array_equal(numbers[:, None] == numbers, (cells[:, None] == cells).all(axis=2))


@given(st.integers(0, 2**32 - 1), st.integers(1, 100))
def test_the_finest_cell_keeps_the_budget(seed: int, budget: int) -> None:
    position = np.random.default_rng(seed).random((100, 3))

    def count_at(cell: float) -> int:
        return len(np.unique(cell_numbers(position, cell)))

    cell = finest_cell(float(position.max()), count_at, budget, 16)
    assert count_at(cell) <= budget
    too_small = (cell - 2 * float(position.max()) / 2**16) * (1 - 1e-12)
    assert budget == 100 or count_at(too_small) > budget


def test_thinning_evens_out_and_keeps_what_is_little() -> None:
    random = np.random.default_rng(0)
    points = random.random((20_000, 2)) ** [3, 1]  # crowded at one end
    points = np.column_stack([points, np.zeros(len(points))])
    thinned = thin(points, 1000)
    assert 800 < len(thinned) <= 1000
    half = (thinned[:, 0] < 0.5).mean()
    assert half == pytest.approx(0.5, abs=0.05)
    assert thin(points, len(points)) is points
