# SPDX-License-Identifier: MIT
"""Mean curvature, gradients and mesh HOG on surfaces where they are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapegoogle_core.descriptors import gradient_histograms, mean_curvature, mesh_hog
from shapegoogle_core.descriptors.gradient_histograms import vertex_gradients
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.measures import vertex_normals
from tests.core.conftest import Shapes


def test_mean_curvature_of_sphere_and_plane(shapes: type[Shapes]) -> None:
    sphere = shapes.sphere(4)
    small = Mesh(0.1 * sphere.vertices, sphere.faces)
    # A function of eigenvalue 2/R², as the positions are, is divided by 1 + 2t/R² in a step of heat flow.
    for smoothing in (3e-3, 1e-2):
        expected = 10 / (1 + 8 * np.pi * smoothing)
        np.testing.assert_allclose(mean_curvature(small, smoothing), expected, rtol=0.01)
    plane = shapes.rectangle(1.0, 1.0, 20)
    assert mean_curvature(plane).max() < 1e-9  # no pull of the rim


def test_gradient_of_a_linear_function(shapes: type[Shapes]) -> None:
    mesh = shapes.rectangle(2.0, 1.0, 12)
    turned = Mesh(mesh.vertices @ Rotation.random(rng=1).as_matrix(), mesh.faces)
    slope = np.array([0.3, -2.0, 0.7])
    normal = vertex_normals(turned)[0]
    expected = slope - (slope @ normal) * normal  # along the surface
    gradients = vertex_gradients(turned, turned.vertices @ slope)
    np.testing.assert_allclose(gradients, np.tile(expected, (len(gradients), 1)), atol=1e-9)


def test_mesh_hog_points_along_the_gradient(shapes: type[Shapes], monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a function rises evenly, all gradients lie along the axis, in all sectors alike."""
    mesh = shapes.rectangle(1.0, 1.0, 40)
    monkeypatch.setattr(gradient_histograms, "mean_curvature", lambda mesh, _: 100 * mesh.vertices[:, 0])
    values = mesh_hog(mesh, radius=0.2, sectors=4, orientations=8, floor=1e-6)
    middle = np.abs(mesh.vertices[:, :2] - 0.5).max(axis=1) < 0.25
    sectors = values[middle].reshape(-1, 4, 8)
    assert (sectors[:, :, 1:] == 0).all()
    np.testing.assert_allclose(sectors[:, :, 0], 0.5, atol=0.2)  # some points lie on an edge of two
    np.testing.assert_allclose(np.linalg.norm(values[middle], axis=1), 1)


def test_mesh_hog_fades_where_nothing_is(shapes: type[Shapes]) -> None:
    assert np.abs(mesh_hog(shapes.sphere(4))).max() < 0.05
