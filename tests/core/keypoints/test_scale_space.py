# SPDX-License-Identifier: MIT
"""Detectors in scale space, curvature and diffusion on shapes where they are known."""

from __future__ import annotations

import numpy as np
import pytest

import shapegoogle_core as sg
from shapegoogle_core.keypoints.scale_space import diffusions, signed_mean_curvature
from shapegoogle_core.laplacian import build_operator
from tests.core.conftest import Shapes
from tests.core.keypoints.bumps import DIRECTIONS, keypoints, with_bumps


class TestScaleSpace:
    def test_signed_mean_curvature_of_a_sphere(self, shapes: type[Shapes]) -> None:
        sphere = shapes.sphere(4)
        large = sg.Mesh(2.5 * sphere.vertices, sphere.faces)
        curvature = signed_mean_curvature(large, build_operator(large))
        # The twelve vertices of an icosphere that have five neighbours are off by a seventh.
        assert np.median(curvature) == pytest.approx(0.4, rel=0.01)
        assert curvature == pytest.approx(0.4, rel=0.15)

    def test_signed_mean_curvature_of_a_flat_sheet_with_a_rim(self, shapes: type[Shapes]) -> None:
        plane = shapes.rectangle(1, 1, 10)
        assert np.abs(signed_mean_curvature(plane, build_operator(plane))).max() < 1e-10

    def test_diffusion_damps_a_wave_as_heat_does(self, shapes: type[Shapes]) -> None:
        """z is an eigenfunction of the unit sphere with eigenvalue 2: it decays as exp(-2t)."""
        sphere = shapes.sphere(4)
        steps = np.linspace(0.002, 0.2, 100)
        z = sphere.vertices[:, 2]
        smoothed = diffusions(build_operator(sphere), z, steps)
        for time, values in ((steps[9], smoothed[9]), (steps[-1], smoothed[-1])):
            assert values @ z / (z @ z) == pytest.approx(np.exp(-2 * time), rel=0.005)

    @pytest.mark.parametrize("detector", ["mesh-dog", "salient-points"])
    def test_a_bump_is_found(self, shapes: type[Shapes], detector: str) -> None:
        centers = DIRECTIONS[:3]
        mesh = with_bumps(shapes.sphere(4), centers, height=0.4, sharpness=15)
        found = keypoints(mesh, detector)
        strongest = mesh.vertices[found.indices[:3]]
        strongest /= np.linalg.norm(strongest, axis=1, keepdims=True)
        cosines = strongest @ centers.T
        assert sorted(cosines.argmax(axis=1)) == [0, 1, 2]
        assert np.degrees(np.arccos(cosines.max(axis=1).clip(-1, 1))).max() < 5

    def test_a_dent_is_found_too(self, shapes: type[Shapes]) -> None:
        mesh = with_bumps(shapes.sphere(4), DIRECTIONS[:1], height=-0.15, sharpness=10)
        strongest = mesh.vertices[keypoints(mesh, "mesh-dog").indices[0]]
        assert strongest @ DIRECTIONS[0] / np.linalg.norm(strongest) > np.cos(np.radians(5))

    def test_a_ridge_is_none(self, shapes: type[Shapes]) -> None:
        """Around a straight fold the difference changes in one direction only."""
        sheet = shapes.rectangle(1, 1, 40)
        x, y, _ = sheet.vertices.T
        fold = sg.Mesh(np.stack([x, y, 0.2 * np.exp(-((x - 0.5) ** 2) / 0.005)], axis=1), sheet.faces)
        found = keypoints(fold, "mesh-dog").indices
        inner = found[np.abs(fold.vertices[found, 1] - 0.5) < 0.25]
        assert len(inner) == 0
