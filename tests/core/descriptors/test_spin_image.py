# SPDX-License-Identifier: MIT
"""Spin images against a plain loop."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.descriptors import vertex_spin_images
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.measures import vertex_areas, vertex_normals


def random_vertices(mesh: Mesh, count: int = 50) -> np.ndarray:
    return np.random.default_rng(0).choice(len(mesh.vertices), count, replace=False)


def test_spin_images_by_a_loop(bumpy: Mesh) -> None:
    radius, rows, columns = 0.3, 5, 3
    images = vertex_spin_images(bumpy, radius, (rows, columns))
    areas, normals, unit = vertex_areas(bumpy), vertex_normals(bumpy), np.sqrt(bumpy.area)
    for vertex in random_vertices(bumpy):
        expected = np.zeros((rows, columns))
        for other, area in enumerate(areas):
            offset = (bumpy.vertices[other] - bumpy.vertices[vertex]) / unit
            height = abs(offset @ normals[vertex])
            distance = np.linalg.norm(np.cross(offset, normals[vertex]))
            if height < radius and distance < radius:
                expected[int(distance / radius * rows), int(height / radius * columns)] += area
        np.testing.assert_allclose(images[vertex], expected.ravel() / expected.sum(), atol=1e-9)
