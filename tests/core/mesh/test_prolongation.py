# SPDX-License-Identifier: MIT
"""Interpolation from the vertices of a mesh to points on or close to it."""

from __future__ import annotations

from typing import Any

import numpy as np
import trimesh

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.prolongation import prolongation


def test_is_linear_interpolation(bumpy: Mesh) -> None:
    random = np.random.default_rng(0)
    weights = random.dirichlet(np.ones(3), len(bumpy.faces))
    points = np.einsum("fc,fcd->fd", weights, bumpy.vertices[bumpy.faces])
    matrix = prolongation(bumpy, points)
    assert np.allclose(matrix.sum(axis=1), 1)
    assert matrix.data.min() >= 0
    assert np.allclose(matrix @ bumpy.vertices, points)


def test_points_beside_the_surface_go_to_the_nearest_one(bumpy: Mesh) -> None:
    random = np.random.default_rng(1)
    points = bumpy.vertices * random.uniform(0.97, 1.03, (len(bumpy.vertices), 1))
    surface = trimesh.Trimesh(bumpy.vertices, bumpy.faces, process=False)
    closest_point: Any = trimesh.proximity.closest_point_naive
    _, least, _ = closest_point(surface, points)
    distance = np.linalg.norm(prolongation(bumpy, points) @ bumpy.vertices - points, axis=1)
    assert (distance >= least - 1e-12).all()
    assert np.allclose(distance, least, atol=1e-3)


def test_vertices_keep_their_values(bumpy: Mesh) -> None:
    values = np.random.default_rng(2).standard_normal(len(bumpy.vertices))
    assert np.allclose(prolongation(bumpy, bumpy.vertices) @ values, values)


def test_flat_faces_are_no_obstacle() -> None:
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]])
    matrix = prolongation(mesh, np.array([[0.25, 0.25, 0.1], [5.0, 0, 0]]))
    assert np.isfinite(matrix.data).all()
    assert np.allclose(matrix.sum(axis=1), 1)
    assert np.allclose(matrix @ mesh.vertices, [[0.25, 0.25, 0.0], [1.0, 0.0, 0.0]])
