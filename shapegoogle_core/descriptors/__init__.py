# SPDX-License-Identifier: MIT
"""Local descriptors of every vertex, from the spectrum or from the mesh (paper, sections 3.1 and 3.2)."""

from shapegoogle_core.descriptors.geodesics import geodesic_histograms
from shapegoogle_core.descriptors.gradient_histograms import mean_curvature, mesh_hog
from shapegoogle_core.descriptors.registry import DESCRIPTORS
from shapegoogle_core.descriptors.shape_context import shape_contexts
from shapegoogle_core.descriptors.spectral import (
    global_point_signature,
    heat_kernel_signature,
    log_heat_kernel_signature,
    scale_invariant_hks,
    wave_kernel_signature,
)
from shapegoogle_core.descriptors.spin_image import spin_images, vertex_spin_images
from shapegoogle_core.descriptors.times import default_exponents, default_times, time_at, time_range
from shapegoogle_core.descriptors.volumetric import volumetric_hks

__all__ = [
    "DESCRIPTORS",
    "default_exponents",
    "default_times",
    "geodesic_histograms",
    "global_point_signature",
    "heat_kernel_signature",
    "log_heat_kernel_signature",
    "mean_curvature",
    "mesh_hog",
    "scale_invariant_hks",
    "shape_contexts",
    "spin_images",
    "time_at",
    "time_range",
    "vertex_spin_images",
    "volumetric_hks",
    "wave_kernel_signature",
]
