# SPDX-License-Identifier: MIT
"""Maxima of the heat kernel on shapes whose tips are known."""

from __future__ import annotations

import numpy as np
import pytest

import shapegoogle_core as sg
from shapegoogle_core.keypoints import detect_keypoints
from tests.core.conftest import Shapes
from tests.core.keypoints.bumps import DIRECTIONS, EIGENPAIRS, keypoints, with_bumps


class TestHeatKernelMaxima:
    @pytest.mark.parametrize("count", [1, 2, 3, 5])
    def test_a_sphere_with_bumps_has_one_on_each(self, shapes: type[Shapes], count: int) -> None:
        centers = DIRECTIONS[:count]
        mesh = with_bumps(shapes.sphere(4), centers)
        found = keypoints(mesh, "hks-maxima")
        directions = mesh.vertices[found.indices]
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        angles = np.degrees(np.arccos(np.clip(directions @ centers.T, -1, 1)))
        assert len(found) == count
        assert sorted(angles.argmin(axis=1)) == list(range(count))
        assert angles.min(axis=1).max() < 4  # an edge

    def test_nothing_stands_out_on_a_sphere(self, shapes: type[Shapes]) -> None:
        assert len(keypoints(shapes.sphere(3), "hks-maxima")) == 0

    def test_response_is_the_rise_over_the_saddle(self, shapes: type[Shapes]) -> None:
        mesh = with_bumps(shapes.sphere(3), DIRECTIONS[:2])
        spectrum = sg.compute_spectrum(mesh, EIGENPAIRS)
        found = detect_keypoints(mesh, spectrum, "hks-maxima", time=0.02)
        heat = sg.heat_kernel_signature(spectrum, 0.02 * spectrum.area)[:, 0]
        assert found.response[0] == pytest.approx(1 - heat.min() / heat.max())
        assert found.indices[0] == heat.argmax()
        more = detect_keypoints(mesh, spectrum, "hks-maxima", time=0.02, persistence=0.9 * found.response[1])
        between = found.response.mean()
        less = detect_keypoints(mesh, spectrum, "hks-maxima", time=0.02, persistence=between)
        assert (len(more), len(less)) == (2, 1)

    def test_a_small_part_does_not_drown_the_large_one(self, shapes: type[Shapes]) -> None:
        large = with_bumps(shapes.sphere(3), DIRECTIONS[:2])
        small = shapes.sphere(2)
        mesh = sg.Mesh(
            np.concatenate([large.vertices, 0.05 * small.vertices + 3]),
            np.concatenate([large.faces, small.faces + len(large.vertices)]),
        )
        assert set(keypoints(large, "hks-maxima").indices) <= set(keypoints(mesh, "hks-maxima").indices)

    def test_bending_changes_nothing(self, shapes: type[Shapes]) -> None:
        flat = shapes.rectangle(2, 1, 40)
        angle = 2 * flat.vertices[:, 0]
        rolled = np.stack([np.sin(angle) / 2, flat.vertices[:, 1], np.cos(angle) / 2], axis=1)
        first, second = (keypoints(mesh, "hks-maxima") for mesh in (flat, sg.Mesh(rolled, flat.faces)))
        # The corners, where heat cannot get away.
        assert set(first.indices) == {0, 20, 40 * 21, 41 * 21 - 1} == set(second.indices)
        assert second.response == pytest.approx(first.response, rel=0.01)
