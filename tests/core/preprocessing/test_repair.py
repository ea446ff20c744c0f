# SPDX-License-Identifier: MIT
"""Repair: welding and dropping."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from shapegoogle_core.mesh import Mesh, unique_edges
from shapegoogle_core.preprocessing import repair, repair_mapped

BALL = trimesh.creation.icosphere(subdivisions=3)


def soup(mesh: Mesh) -> Mesh:
    """Every face with three vertices of its own."""
    return Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))


def is_closed_manifold(mesh: Mesh) -> bool:
    return bool((unique_edges(mesh)[1] == 2).all())


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("offset", [0.0, 100.0])
def test_soup_becomes_the_surface_it_was(unit: float, offset: float) -> None:
    """Also with the rounding of single precision, in any unit and far from the origin."""
    ball = Mesh((BALL.vertices + offset).astype(np.float32) * unit, BALL.faces)
    rng = np.random.default_rng(0)
    scattered = soup(ball)
    noise = rng.uniform(-3e-7, 3e-7, scattered.vertices.shape) * unit
    repaired = repair(Mesh(scattered.vertices + noise, scattered.faces))
    assert len(repaired.vertices) == len(ball.vertices)
    assert len(repaired.faces) == len(ball.faces)
    assert is_closed_manifold(repaired)
    assert repaired.area == pytest.approx(ball.area, rel=1e-5)


def test_vertices_are_welded_across_any_grid_wall() -> None:
    """Pairs at half the tolerance, anywhere in the box, all become one vertex."""
    rng = np.random.default_rng(1)
    points = rng.uniform(0, 1, (5000, 3))
    diagonal = np.sqrt(3)
    step = rng.normal(size=points.shape)
    step *= 0.5e-6 * diagonal / np.linalg.norm(step, axis=1, keepdims=True)
    cloud = repair(Mesh(np.concatenate([points, points + step])))
    assert np.array_equal(cloud.vertices, points)


def test_what_lies_apart_stays_apart() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1e-5, 0, 0], [1, 1e-5, 0], [1e-5, 1, 0]])
    mesh = Mesh(points, [[0, 1, 2], [3, 4, 5]])
    assert len(repair(mesh).vertices) == 6


def test_stray_vertex_far_away_does_not_weld_the_model() -> None:
    vertices = np.concatenate([BALL.vertices, [[0, 0, 1e7]]])
    mesh = Mesh(vertices, np.concatenate([BALL.faces, [[0, 1, len(vertices) - 1]]]))
    assert len(repair(mesh).faces) == len(mesh.faces)


def test_crowd_in_one_place() -> None:
    """A hundred thousand coincident vertices take no quadratic time or memory."""
    vertices = np.concatenate([BALL.vertices, np.zeros((100_000, 3))])
    extra = len(BALL.vertices) + np.arange(99_999).reshape(-1, 3)
    repaired = repair(Mesh(vertices, np.concatenate([BALL.faces, extra])))
    assert len(repaired.faces) == len(BALL.faces)


def test_drops_what_is_no_part_of_the_surface() -> None:
    faces = BALL.faces.tolist()
    a, b, c = faces[0]
    middle = len(BALL.vertices)
    vertices = np.concatenate([BALL.vertices, [(BALL.vertices[a] + BALL.vertices[b]) / 2], [[0.1, 0.2, 0.3]]])
    junk = [[a, a, b], [a, b, middle], [b, c, a], [c, b, a]]
    repaired = repair(Mesh(vertices, junk[:2] + faces + junk[2:]))
    assert np.array_equal(repaired.faces, BALL.faces)
    assert np.array_equal(repaired.vertices, BALL.vertices)


def test_minus_zero_is_zero() -> None:
    tent = [[-0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -0.0, 0.0], [0.0, 0.0, 1.0]]
    assert len(repair(Mesh(tent, [[0, 1, 2], [3, 1, 4]])).vertices) == 4


def test_clean_mesh_is_returned_as_it_is() -> None:
    mesh = Mesh(BALL.vertices, BALL.faces, "ball")
    assert repair(mesh) is mesh


def test_name_is_kept() -> None:
    assert (
        repair(
            soup(Mesh(BALL.vertices, BALL.faces)).__class__(BALL.vertices[BALL.faces[:, 0]], name="points")
        ).name
        == "points"
    )


coordinates = st.integers(0, 3).map(float) | st.floats(-1, 1, width=32) | st.just(1e-7) | st.just(1 + 1e-6)


@st.composite
def meshes(draw: st.DrawFn) -> Mesh:
    """Small meshes with much that has to be repaired."""
    vertices = draw(st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=1, max_size=30))
    corner = st.integers(0, len(vertices) - 1)
    return Mesh(vertices, draw(st.lists(st.tuples(corner, corner, corner), max_size=40)) or None)


@settings(max_examples=100, deadline=None)
@given(meshes())
def test_repairing_twice_changes_nothing(mesh: Mesh) -> None:
    once = repair(mesh)
    twice = repair(once)
    assert np.array_equal(once.vertices, twice.vertices)
    assert np.array_equal(once.faces, twice.faces)


@settings(max_examples=100, deadline=None)
@given(meshes())
def test_result_is_clean(mesh: Mesh) -> None:
    repaired = repair(mesh)
    originals = {tuple(vertex) for vertex in mesh.vertices}
    assert {tuple(vertex) for vertex in repaired.vertices} <= originals
    if not repaired.is_point_cloud:
        assert np.array_equal(np.unique(repaired.faces), np.arange(len(repaired.vertices)))
        corners = np.sort(repaired.faces, axis=1)
        assert (np.diff(corners, axis=1) > 0).all()
        assert len(np.unique(corners, axis=0)) == len(corners)


@settings(max_examples=50, deadline=None)
@given(meshes(), st.randoms(use_true_random=False))
def test_same_surface_whatever_the_order_of_faces(mesh: Mesh, random: Random) -> None:
    order = list(range(len(mesh.faces)))
    random.shuffle(order)
    shuffled = repair(Mesh(mesh.vertices, mesh.faces[order]))
    assert shuffled.area == pytest.approx(repair(mesh).area)


def test_soup_with_rounding_errors_welds_as_pairs_within_the_tolerance_do() -> None:
    """Vertices are compared only where there may be another; that must not lose any."""
    rng = np.random.default_rng(0)
    points = rng.uniform(size=(3000, 3))
    crowd = points[rng.integers(0, 3000, 4000)]
    step = 0.4e-6 * np.sqrt(3) * rng.uniform(-0.5, 0.5, crowd.shape)
    cloud = repair(Mesh(np.concatenate([points, crowd + step, crowd])))
    assert np.array_equal(cloud.vertices, points)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_mapped_vertices_are_found_where_they_were(seed: int) -> None:
    random = np.random.default_rng(seed)
    vertices = random.integers(0, 3, (30, 3)).astype(float)
    mesh = Mesh(vertices, random.integers(0, 30, (25, 3)))
    repaired, place = repair_mapped(mesh)
    assert np.array_equal(repaired.vertices, repair(mesh).vertices)
    kept = place >= 0
    assert np.array_equal(repaired.vertices[place[kept]], vertices[kept])
    assert set(place[kept]) == set(range(len(repaired.vertices)))


def test_a_clean_mesh_is_mapped_to_itself(bumpy: Mesh) -> None:
    repaired, place = repair_mapped(bumpy)
    assert repaired is bumpy
    assert np.array_equal(place, np.arange(len(bumpy.vertices)))
