# SPDX-License-Identifier: MIT
"""Spheres with bumps, and their keypoints."""

from __future__ import annotations

import numpy as np

import shapegoogle_core as sg
from shapegoogle_core.keypoints import detect_keypoints

DIRECTIONS = np.array([[1.0, 0.2, 0.1], [-0.3, 1, 0.2], [0.2, -0.4, 1], [-1, -0.8, -0.9], [0.6, -1, -0.5]])
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
EIGENPAIRS = 60


def with_bumps(sphere: sg.Mesh, centers: np.ndarray, height: float = 0.6, sharpness: float = 30.0) -> sg.Mesh:
    """A unit sphere with a bump at each of some unit vectors."""
    rise = height * np.exp(-sharpness * (1 - sphere.vertices @ centers.T)).sum(axis=1)
    return sg.Mesh(sphere.vertices * (1 + rise)[:, None], sphere.faces, "bumps")


def keypoints(mesh: sg.Mesh, detector: str, **parameters: float) -> sg.Keypoints:
    return detect_keypoints(mesh, sg.compute_spectrum(mesh, EIGENPAIRS), detector, **parameters)
