# SPDX-License-Identifier: MIT
"""Local descriptors by name, as the channels of a model use them."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import cast

import numpy as np

from shapegoogle_core.api.registry import Plugin, PluginShapeError, Registry, check_takes
from shapegoogle_core.descriptors.geodesics import geodesic_histograms
from shapegoogle_core.descriptors.gradient_histograms import mesh_hog
from shapegoogle_core.descriptors.shape_context import shape_contexts
from shapegoogle_core.descriptors.spectral import (
    global_point_signature,
    heat_kernel_signature,
    log_heat_kernel_signature,
    scale_invariant_hks,
    wave_kernel_signature,
)
from shapegoogle_core.descriptors.spin_image import vertex_spin_images
from shapegoogle_core.descriptors.volumetric import volumetric_hks
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.spectral import Spectrum

__all__ = ["DESCRIPTORS", "Descriptor"]

Descriptor = Callable[..., FloatArray]
"""Called with a mesh, its spectrum and the parameters of a channel; returns (n, d) values."""


def _hks(
    _mesh: Mesh,
    spectrum: Spectrum,
    times: Sequence[float],
    multiply_by_time: bool = False,
    normalize: bool = False,
) -> FloatArray:
    return heat_kernel_signature(spectrum, times, multiply_by_time=multiply_by_time, normalize=normalize)


def _log_hks(_mesh: Mesh, spectrum: Spectrum, times: Sequence[float]) -> FloatArray:
    return log_heat_kernel_signature(spectrum, times)


def _si_hks(
    _mesh: Mesh,
    spectrum: Spectrum,
    alpha: float,
    tau_start: float,
    tau_end: float,
    tau_step: float,
    frequencies: int,
) -> FloatArray:
    tau = np.arange(tau_start, tau_end + tau_step / 2, tau_step)
    return scale_invariant_hks(spectrum, alpha=alpha, tau=tau, frequencies=frequencies)


def _wks(_mesh: Mesh, spectrum: Spectrum, low: float, high: float, count: int, sigma: float) -> FloatArray:
    kernel = wave_kernel_signature(spectrum, np.linspace(low, high, count), sigma=sigma)
    return np.log(np.maximum(kernel * spectrum.area, math.exp(-10)))


def _gps(_mesh: Mesh, spectrum: Spectrum, count: int = 15) -> FloatArray:
    # An eigenfunction has no sign of its own.
    return np.abs(global_point_signature(spectrum, count))


# Histograms are square-rooted: their Euclidean distance is then that of Hellinger, in which a difference
# between small shares counts as well.


def _spin_images(
    mesh: Mesh, _spectrum: Spectrum, radius: float = 0.4, distances: int = 8, heights: int = 4
) -> FloatArray:
    return np.sqrt(vertex_spin_images(mesh, radius, (distances, heights)))


def _shape_context(
    mesh: Mesh,
    _spectrum: Spectrum,
    inner: float = 0.05,
    outer: float = 1.0,
    shells: int = 8,
    elevations: int = 4,
) -> FloatArray:
    return np.sqrt(shape_contexts(mesh, inner, outer, shells, elevations))


def _mesh_hog(
    mesh: Mesh, _spectrum: Spectrum, radius: float = 0.2, sectors: int = 4, orientations: int = 8
) -> FloatArray:
    return mesh_hog(mesh, radius, sectors, orientations)


def _geodesic_histogram(mesh: Mesh, _spectrum: Spectrum, radius: float = 0.3, bins: int = 8) -> FloatArray:
    return np.sqrt(geodesic_histograms(mesh, radius, bins))


def _volumetric_hks(
    mesh: Mesh,
    _spectrum: Spectrum,
    times: Sequence[float] = (0.0016, 0.0032, 0.0064, 0.0128, 0.0256, 0.0512),
    resolution: int = 30,
    eigenpairs: int = 100,
) -> FloatArray:
    return volumetric_hks(mesh, times, resolution, eigenpairs)


def _from_plugin(value: object, plugin: Plugin) -> Descriptor:
    check_takes(value, plugin, ("mesh", "spectrum"), more=True)
    descriptor = cast(Callable[..., object], value)

    @functools.wraps(descriptor)
    def checked(mesh: Mesh, spectrum: Spectrum, **parameters: object) -> FloatArray:
        with plugin.blamed(PluginShapeError, mesh.name):
            values = np.asarray(descriptor(mesh, spectrum, **parameters), np.float64)
        if values.ndim != 2 or len(values) != len(mesh.vertices) or not values.size:
            wanted = (
                f"return (n, d) numbers, d for each of the {len(mesh.vertices)} vertices of {mesh.name!r}"
            )
            raise plugin.unfit(wanted, PluginShapeError)
        if not np.isfinite(values).all():
            raise plugin.unfit(f"return finite numbers, also for {mesh.name!r}", PluginShapeError)
        return values

    return checked


DESCRIPTORS: Registry[Descriptor] = Registry(
    "descriptor",
    "shapegoogle.descriptors",
    {
        "hks": _hks,
        "log-hks": _log_hks,
        "si-hks": _si_hks,
        "wks": _wks,
        "gps": _gps,
        "spin-images": _spin_images,
        "shape-context": _shape_context,
        "mesh-hog": _mesh_hog,
        "geodesic-histogram": _geodesic_histogram,
        "volumetric-hks": _volumetric_hks,
    },
    _from_plugin,
)
"""Local descriptors by name.

Each is called with a mesh, its spectrum and the parameters of a channel, and returns (n, d) values.
Descriptors of the spectrum take times in squared mesh units; the others take lengths as shares of the square
root of the mesh's area, and times as shares of the area, so that the size does not matter."""
