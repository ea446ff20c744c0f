# SPDX-License-Identifier: MIT
"""Areas and normals of vertices."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.measures import face_areas, vertex_areas, vertex_normals
from tests.core.conftest import Shapes


def test_areas_of_vertices_sum_to_those_of_faces(bumpy: Mesh) -> None:
    np.testing.assert_allclose(vertex_areas(bumpy).sum(), face_areas(bumpy).sum())


def test_normals_of_a_sphere_point_outwards(shapes: type[Shapes]) -> None:
    sphere = shapes.sphere(3)
    np.testing.assert_allclose(vertex_normals(sphere), sphere.vertices, atol=0.02)
