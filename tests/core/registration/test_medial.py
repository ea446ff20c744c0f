# SPDX-License-Identifier: MIT
"""Balls inside simple surfaces have the radius that geometry says."""

from __future__ import annotations

import numpy as np
import pytest

from shapegoogle_core.registration.medial import medial_radii


def sphere(count: int, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Points spread evenly over a sphere (a spiral with the golden angle), and outward normals."""
    height = 1 - (2 * np.arange(count) + 1) / count
    angle = np.pi * (3 - np.sqrt(5)) * np.arange(count)
    across = np.sqrt(1 - height**2)
    normals = np.stack([across * np.cos(angle), across * np.sin(angle), height], axis=1)
    return radius * normals, normals


@pytest.mark.parametrize("outward", [1, -1])
def test_the_ball_in_a_sphere_is_the_sphere(outward: int) -> None:
    points, normals = sphere(3000, 0.3)
    radii = medial_radii(points[::30], outward * normals[::30], points, largest=1.0)
    np.testing.assert_allclose(points[::30] - radii[:, None] * outward * normals[::30], 0, atol=0.02)
    np.testing.assert_allclose(radii, outward * 0.3, rtol=0.05)


def test_a_shell_has_half_its_thickness() -> None:
    """Of two concentric spheres the balls between them touch both."""
    outer, normals = sphere(6000, 1.0)
    inner, _ = sphere(4000, 0.8)
    radii = medial_radii(outer[::60], normals[::60], np.concatenate([outer, inner]), largest=2.0)
    np.testing.assert_allclose(radii, 0.1, rtol=0.2)


def test_a_flat_sheet_has_the_largest_ball() -> None:
    points = np.random.default_rng(0).uniform(size=(500, 3)) * [1, 1, 0]
    radii = medial_radii(points[:20], np.tile([0.0, 0, 1], (20, 1)), points, largest=0.5)
    np.testing.assert_allclose(np.abs(radii), 0.5)
