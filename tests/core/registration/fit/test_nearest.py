# SPDX-License-Identifier: MIT
"""Nearest points of triangles: compared with all triangles, on faces that a search by centres gets wrong."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import shapegoogle_core as sg
from benchmarks.flat_parts import make_parts
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration import Surface
from shapegoogle_core.registration.fit.nearest import TriangleTree, nearest_on_triangles


def compared_with_all(triangles: FloatArray, points: FloatArray) -> FloatArray:
    everywhere = [
        nearest_on_triangles(triangles, np.repeat(point[None], len(triangles), 0)) for point in points
    ]
    return np.array(
        [np.linalg.norm(found - point, axis=1).min() for found, point in zip(everywhere, points, strict=True)]
    )


@pytest.mark.parametrize("family", ["plate with holes", "sheet", "bracket", "profile"])
def test_long_thin_triangles_have_exact_nearest_points(family: str) -> None:
    mesh = next(make_parts([family])).mesh
    triangles = mesh.vertices[mesh.faces]
    random = np.random.default_rng(0)
    faces = random.integers(len(triangles), size=120)
    corners = random.dirichlet([1, 1, 1], 120)
    on_surface = (triangles[faces] * corners[:, :, None]).sum(axis=1)
    away = random.choice([0, 1e-4, 0.02, 0.5], 120)[:, None] * np.sqrt(mesh.area)
    points = on_surface + random.normal(size=(120, 3)) * away
    nearest, found = TriangleTree(triangles).nearest(points)
    distances = np.linalg.norm(nearest - points, axis=1)
    assert distances == pytest.approx(compared_with_all(triangles, points), abs=1e-9 * np.sqrt(mesh.area))
    again = nearest_on_triangles(triangles[found], points)
    assert np.abs(again - nearest).max() == 0


def test_nearest_point_agrees_with_another_implementation() -> None:
    random = np.random.default_rng(1)
    triangles, points = random.normal(size=(500, 3, 3)), 2 * random.normal(size=(500, 3))
    expected = trimesh.triangles.closest_point(triangles, points)  # type: ignore[no-untyped-call]
    assert nearest_on_triangles(triangles, points) == pytest.approx(expected, abs=1e-9)


def test_triangles_without_area_count_as_segments_and_points() -> None:
    segment = [[0.0, 0, 0], [2, 0, 0], [1, 0, 0]]
    point = [[0.0, 5, 0], [0, 5, 0], [0, 5, 0]]
    nearest, faces = TriangleTree(np.array([segment, point])).nearest(np.array([[1.5, 1, 0], [0, 4, 0]]))
    assert nearest.tolist() == [[1.5, 0, 0], [0, 5, 0]]
    assert faces.tolist() == [0, 1]


@pytest.mark.parametrize("family", ["plate with holes", "sheet"])
def test_own_sample_lies_on_own_surface(family: str) -> None:
    mesh = next(make_parts([family])).mesh
    signature = sg.load_model().describe(mesh, keep_surface=True)
    assert signature.surface is not None
    assert signature.sample is not None
    points = signature.sample.points
    nearest, _ = Surface(signature.surface, signature.sample).nearest(points)
    assert np.linalg.norm(points - nearest, axis=1).max() < 1e-9
