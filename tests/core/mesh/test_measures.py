# SPDX-License-Identifier: MIT
"""Areas and normals of vertices and of the points of a cloud."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.measures import (
    bounding_box,
    dots,
    face_areas,
    face_normals,
    point_normals,
    vertex_areas,
    vertex_normals,
)
from shapegoogle_core.preprocessing import smooth
from tests.core.conftest import Shapes


def test_areas_of_vertices_sum_to_those_of_faces(bumpy: Mesh) -> None:
    np.testing.assert_allclose(vertex_areas(bumpy).sum(), face_areas(bumpy).sum())


def test_normals_of_a_sphere_point_outwards(shapes: type[Shapes]) -> None:
    sphere = shapes.sphere(3)
    np.testing.assert_allclose(vertex_normals(sphere), sphere.vertices, atol=0.02)


def test_normals_and_smoothing_of_the_points_of_a_sphere() -> None:
    random = np.random.default_rng(0).standard_normal((3000, 3))
    ball = random / np.linalg.norm(random, axis=1, keepdims=True)
    along = np.abs((point_normals(ball) * ball).sum(axis=1))
    assert along.min() > 0.95
    noisy = Mesh(ball + 0.02 * np.random.default_rng(1).standard_normal(ball.shape))
    rough, smoothed = (
        np.linalg.norm(points, axis=1).std() for points in (noisy.vertices, smooth(noisy, 3e-4).vertices)
    )
    assert smoothed < rough / 2


def test_normals_and_areas_of_faces_are_those_of_cross_products(bumpy: Mesh) -> None:
    a, b, c = (bumpy.vertices[corner] for corner in bumpy.faces.T)
    product = np.cross(b - a, c - b)
    length = np.linalg.norm(product, axis=1)
    normals, areas = face_normals(bumpy)
    assert (areas == length / 2).all()
    assert (normals == product / length[:, None]).all()


def test_boxes_and_dot_products_are_those_of_numpy(bumpy: Mesh) -> None:
    points = bumpy.vertices
    low, high = bounding_box(points)
    assert low.tolist() == points.min(axis=0).tolist()
    assert high.tolist() == points.max(axis=0).tolist()
    assert (dots(points, points[::-1]) == (points * points[::-1]).sum(axis=1)).all()
