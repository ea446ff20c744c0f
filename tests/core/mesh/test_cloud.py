# SPDX-License-Identifier: MIT
"""Geometry of point clouds."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.cloud import point_normals
from shapegoogle_core.preprocessing import smooth


def test_normals_and_smoothing_of_a_sphere() -> None:
    random = np.random.default_rng(0).standard_normal((3000, 3))
    ball = random / np.linalg.norm(random, axis=1, keepdims=True)
    along = np.abs((point_normals(ball) * ball).sum(axis=1))
    assert along.min() > 0.95
    noisy = Mesh(ball + 0.02 * np.random.default_rng(1).standard_normal(ball.shape))
    rough, smoothed = (
        np.linalg.norm(points, axis=1).std() for points in (noisy.vertices, smooth(noisy, 3e-4).vertices)
    )
    assert smoothed < rough / 2
