# SPDX-License-Identifier: MIT
"""Shape contexts against a plain loop."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.descriptors import shape_contexts
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.measures import vertex_areas, vertex_normals


def random_vertices(mesh: Mesh, count: int = 50) -> np.ndarray:
    return np.random.default_rng(0).choice(len(mesh.vertices), count, replace=False)


def test_shape_contexts_by_a_loop(bumpy: Mesh) -> None:
    edges, elevations = np.geomspace(0.1, 0.8, 4), 3
    contexts = shape_contexts(bumpy, 0.1, 0.8, shells=4, elevations=elevations)
    areas, normals, unit = vertex_areas(bumpy), vertex_normals(bumpy), np.sqrt(bumpy.area)
    for vertex in random_vertices(bumpy):
        expected = np.zeros((4, elevations))
        for other, area in enumerate(areas):
            if other != vertex:
                offset = (bumpy.vertices[other] - bumpy.vertices[vertex]) / unit
                shell = min(int((np.linalg.norm(offset) > edges).sum()), 3)
                cosine = abs(offset @ normals[vertex]) / np.linalg.norm(offset)
                expected[shell, int(cosine * elevations)] += area / unit**2
        np.testing.assert_allclose(contexts[vertex], expected.ravel(), atol=1e-9)
    np.testing.assert_allclose(contexts.sum(axis=1), 1 - areas / unit**2)
