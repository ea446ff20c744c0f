# SPDX-License-Identifier: MIT
"""Keypoint detectors by name."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import cast

import numpy as np

from shapegoogle_core.api.registry import Plugin, PluginShapeError, Registry, check_takes
from shapegoogle_core.keypoints.harris import harris_3d
from shapegoogle_core.keypoints.heat import hks_maxima
from shapegoogle_core.keypoints.scale_space import mesh_dog, salient_points
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.spectral import Spectrum

__all__ = ["DETECTORS", "Detector"]

Detector = Callable[..., FloatArray]
"""Called with a mesh, its spectrum and its parameters; returns (n,) responses."""


def _from_plugin(value: object, plugin: Plugin) -> Detector:
    check_takes(value, plugin, ("mesh", "spectrum"), more=True)
    detector = cast(Callable[..., object], value)

    @functools.wraps(detector)
    def checked(mesh: Mesh, spectrum: Spectrum, **parameters: object) -> FloatArray:
        with plugin.blamed(PluginShapeError, mesh.name):
            response = np.asarray(detector(mesh, spectrum, **parameters), np.float64)
        if response.shape != (len(mesh.vertices),) or not np.isfinite(response).all():
            wanted = f"return a finite number for each of the {len(mesh.vertices)} vertices of {mesh.name!r}"
            raise plugin.unfit(wanted, PluginShapeError)
        return response

    return checked


DETECTORS: Registry[Detector] = Registry(
    "keypoint detector",
    "shapegoogle.keypoint_detectors",
    {
        "hks-maxima": hks_maxima,
        "mesh-dog": mesh_dog,
        "salient-points": salient_points,
        "harris-3d": harris_3d,
    },
    _from_plugin,
)
"""Keypoint detectors by name.

Each is called with a mesh, its spectrum and its parameters, and returns (n,) responses: positive at the
keypoints, 0 at all other vertices. Lengths among the parameters are shares of √area, times are shares of the
area."""
