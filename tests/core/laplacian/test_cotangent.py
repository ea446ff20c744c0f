# SPDX-License-Identifier: MIT
"""Mixed Voronoi areas of cotangent weights."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapegoogle_core.laplacian.cotangent import voronoi_areas
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.measures import vertex_areas
from tests.core.conftest import Shapes


def test_voronoi_areas_of_a_right_grid_an_equilateral_and_an_obtuse_triangle(shapes: type[Shapes]) -> None:
    grid = shapes.rectangle(1.0, 1.0, 8)
    x, y, _ = grid.vertices.T
    inner = (np.minimum(x, 1 - x) > 1e-9) & (np.minimum(y, 1 - y) > 1e-9)
    np.testing.assert_allclose(voronoi_areas(grid)[inner], 1 / 64)
    equilateral = Mesh([[0, 0, 0], [1, 0, 0], [0.5, 0.75**0.5, 0]], [[0, 1, 2]])
    np.testing.assert_allclose(voronoi_areas(equilateral), vertex_areas(equilateral))
    acute = Mesh([[0, 0, 0], [4, 0, 0], [1, 3, 0]], [[0, 1, 2]])
    # The circumcentre is (2, 1): quadrilaterals from a corner over the middles of its sides.
    np.testing.assert_allclose(voronoi_areas(acute), [2.25, 1.75, 2.0])
    obtuse = Mesh([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [2.0, 0.5, 0.0]], [[0, 1, 2]])
    np.testing.assert_allclose(voronoi_areas(obtuse), [0.25, 0.25, 0.5])


def test_voronoi_area_is_what_is_nearest_to_a_vertex() -> None:
    """Against counting random points of an acute triangle."""
    corners = np.array([[0, 0, 0], [4, 0, 0], [1, 3, 0.0]])
    random = np.random.default_rng(0)
    weights = random.dirichlet(np.ones(3), 200_000)
    nearest = np.linalg.norm((weights @ corners)[:, None] - corners, axis=2).argmin(axis=1)
    expected = np.bincount(nearest) / len(nearest) * 6
    np.testing.assert_allclose(voronoi_areas(Mesh(corners, [[0, 1, 2]])), expected, atol=0.02)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10_000), flatness=st.floats(-9, 0))
def test_voronoi_areas_are_positive_and_sum_to_the_area(seed: int, flatness: float) -> None:
    points = np.random.default_rng(seed).standard_normal((12, 3)) * [1, 1, 10.0**flatness]
    mesh = Mesh(points, np.arange(12).reshape(4, 3))
    areas = voronoi_areas(mesh)
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(mesh.area)
