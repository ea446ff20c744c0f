# SPDX-License-Identifier: MIT
"""Harris 3D on a cube, and its quadrics on surfaces of known curvature."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import shapegoogle_core as sg
from shapegoogle_core.keypoints.harris import fit_quadrics, harris_response
from shapegoogle_core.keypoints.surroundings import discs
from tests.core.conftest import Shapes
from tests.core.keypoints.bumps import keypoints


@pytest.fixture(scope="module")
def cube() -> sg.Mesh:
    box = trimesh.creation.box()
    for _ in range(4):
        box = box.subdivide()
    return sg.Mesh(box.vertices, box.faces, "cube")


class TestHarris:
    def test_corners_of_a_cube(self, cube: sg.Mesh) -> None:
        found = cube.vertices[keypoints(cube, "harris-3d").indices]
        assert len(np.unique(np.sign(found), axis=0)) == 8 == len(found)
        # Within an edge of the mesh.
        assert np.linalg.norm(np.abs(found) - 0.5, axis=1).max() < 1 / 15

    def test_edges_are_below_and_faces_at_zero(self, cube: sg.Mesh) -> None:
        spectrum = sg.compute_spectrum(cube, 4)
        joined, everywhere = discs(cube, 0.12), np.arange(len(cube.vertices))
        response = harris_response(fit_quadrics(cube, spectrum.mass, joined, everywhere, unit=0.12))
        beside = 0.5 - np.abs(cube.vertices)
        near = (beside < 0.25).sum(axis=1)  # of how many further faces a vertex is near, and its own
        edge = ((beside < 1e-9).sum(axis=1) == 2) & (near == 2)
        assert response[edge].max() < 0
        assert np.abs(response[near == 1]).max() < 1e-12

    def test_response_by_integration(self) -> None:
        """The closed form of E, against the mean of ∇z∇zᵀ by Gauss-Hermite quadrature."""
        quadric = np.random.default_rng(0).standard_normal(6)
        p1, p2, p3, p4, p5, _ = quadric
        nodes, weights = np.polynomial.hermite_e.hermegauss(5)
        x, y = np.meshgrid(nodes, nodes)
        weight = np.outer(weights, weights) / weights.sum() ** 2
        slope = np.stack([p1 * x + p2 * y + p4, p2 * x + p3 * y + p5])
        matrix = np.einsum("ixy,jxy,xy->ij", slope, slope, weight)
        expected = np.linalg.det(matrix) - 0.04 * np.trace(matrix) ** 2
        assert harris_response(quadric[None])[0] == pytest.approx(expected)

    def test_quadrics_of_a_sphere(self, shapes: type[Shapes]) -> None:
        sphere = shapes.sphere(4)
        spectrum = sg.compute_spectrum(sphere, 4)
        p1, p2, p3, *_ = fit_quadrics(
            sphere, spectrum.mass, discs(sphere, 0.15), np.arange(len(sphere.vertices))
        ).T
        # Curvature 1 in every direction, whichever way the normal looks.
        assert np.abs(np.abs(p1) - 1).max() < 0.03
        assert np.abs(np.abs(p3) - 1).max() < 0.03
        assert np.abs(p2).max() < 0.03

    def test_quadrics_of_a_function(self, shapes: type[Shapes]) -> None:
        plane = shapes.rectangle(1, 1, 20)
        x, y, _ = plane.vertices.T
        center = np.array([10 * 21 + 10])
        joined, mass = discs(plane, 0.2)[center], np.ones(len(x))
        quadric = fit_quadrics(plane, mass, joined, center, 3 * (x - 0.5) ** 2 + (y - 0.5) ** 2 / 2 + x)[0]
        curvatures = np.linalg.eigvalsh(quadric[[0, 1, 1, 2]].reshape(2, 2))
        assert curvatures == pytest.approx([1, 6], rel=1e-3)
        assert np.hypot(quadric[3], quadric[4]) == pytest.approx(1, rel=1e-3)
