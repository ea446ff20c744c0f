# SPDX-License-Identifier: MIT
"""Distances along surfaces and their histograms, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from shapegoogle_core.descriptors import geodesic_histograms
from shapegoogle_core.descriptors.geodesics import geodesic_neighbors, surface_graph
from shapegoogle_core.mesh import Mesh
from tests.core.conftest import Shapes


def test_the_surface_graph_of_a_plane_is_nearly_euclidean(shapes: type[Shapes]) -> None:
    mesh = shapes.rectangle(1.5, 1.0, 30)
    for chunk, center, neighbor, distance in geodesic_neighbors(mesh, 0.4):
        offsets = mesh.vertices[neighbor] - mesh.vertices[chunk][center]
        straight = np.linalg.norm(offsets, axis=1) / np.sqrt(mesh.area)
        assert (distance >= straight * (1 - 1e-9)).all()
        assert (distance <= straight * 1.09 + 1e-9).all()  # a grid of right angles: 1.082 between 45° and 90°
        inside = straight < 0.9 * 0.4
        assert distance[inside].sum() < 1.06 * straight[inside].sum()


def test_paths_across_an_edge_are_those_of_the_unfolded_triangles() -> None:
    for angle in (0.0, 0.5, 2.0):
        points: list[list[float]] = [
            [0, 0, 0],
            [0, 1, 0],
            [-0.5, 0.5, 0],
            [0.7 * np.cos(angle), 0.6, 0.7 * np.sin(angle)],
        ]
        graph = surface_graph(Mesh(points, [[0, 1, 2], [1, 0, 3]])).toarray()
        assert graph[2, 3] == pytest.approx(np.hypot(1.2, 0.1))
    # Here the straight line misses the edge.
    points = [[0, 0, 0], [0, 1, 0], [-0.1, 5, 0], [0.1, 4, 0]]
    assert surface_graph(Mesh(points, [[0, 1, 2], [1, 0, 3]])).toarray()[2, 3] == 0


def test_geodesic_histogram_of_a_strip(shapes: type[Shapes]) -> None:
    # Along a narrow strip the way to a point is its distance along it: d bins end at r √(k/d) on both sides.
    strip = shapes.rectangle(5.0, 0.05, 500)
    unit, radius, bins = np.sqrt(strip.area), 2.0, 4
    values = geodesic_histograms(strip, radius, bins)
    edges = radius * unit * np.sqrt(np.arange(bins + 1) / bins)
    expected = 2 * np.diff(edges) * 0.05 / (np.pi * (radius * unit) ** 2 / bins)
    middle = np.abs(strip.vertices[:, 0] - 2.5) < 2.5 - edges[-1] - 0.1
    assert middle.any()
    np.testing.assert_allclose(values[middle], np.tile(expected, (middle.sum(), 1)), rtol=0.05)
    end = strip.vertices[:, 0] == 0
    np.testing.assert_allclose(values[end], np.tile(expected / 2, (end.sum(), 1)), rtol=0.05)


def test_geodesic_histogram_of_a_sphere(shapes: type[Shapes]) -> None:
    # The cap within a distance s has the area 2πR² (1 - cos(s/R)), and here 4πR² = 1.
    values = geodesic_histograms(shapes.sphere(4), 0.4, 4)
    edges, radius = 0.4 * np.sqrt(np.arange(5) / 4), 1 / np.sqrt(4 * np.pi)
    expected = 2 * np.pi * radius**2 * np.diff(-np.cos(edges / radius)) / (np.pi * 0.4**2 / 4)
    np.testing.assert_allclose(values.mean(axis=0), expected, rtol=0.05)
    assert values.std(axis=0).max() < 0.05


def test_geodesic_histogram_forgets_a_fold(shapes: type[Shapes]) -> None:
    flat = shapes.rectangle(1.0, 1.0, 20)
    x, y, z = flat.vertices.T
    folded = Mesh(np.stack([np.abs(x - 0.5), y, z], axis=1), flat.faces)
    radius = 0.3871  # no way of the grid ends on the edge of two bins
    np.testing.assert_allclose(
        geodesic_histograms(folded, radius), geodesic_histograms(flat, radius), atol=1e-6
    )
