# SPDX-License-Identifier: MIT
"""Keypoint detectors by name."""

from __future__ import annotations

from collections.abc import Callable

from shapegoogle_core.keypoints.harris import harris_3d
from shapegoogle_core.keypoints.heat import hks_maxima
from shapegoogle_core.keypoints.scale_space import mesh_dog, salient_points
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["DETECTORS"]

DETECTORS: dict[str, Callable[..., FloatArray]] = {
    "hks-maxima": hks_maxima,
    "mesh-dog": mesh_dog,
    "salient-points": salient_points,
    "harris-3d": harris_3d,
}
"""Keypoint detectors by name.

Each is called with a mesh, its spectrum and its parameters, and returns (n,) responses: positive at the
keypoints, 0 at all other vertices. Lengths among the parameters are shares of √area, times are shares of the
area."""
