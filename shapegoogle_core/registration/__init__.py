# SPDX-License-Identifier: MIT
"""Alignment of surfaces: the motion that brings one onto another, and how much of each lies on the other."""

from shapegoogle_core.registration.alignment import Alignment, align, measure
from shapegoogle_core.registration.exact_fit import RoughPose, fit_exactly, rough_pose
from shapegoogle_core.registration.frames import Frame
from shapegoogle_core.registration.isometry import Isometry, functional_map, spectral_difference
from shapegoogle_core.registration.local_words import LocalSettings, LocalWords, fit_local_words
from shapegoogle_core.registration.prepared_sample import PART_SCALES, SCALES, SHARED_SCALES, PreparedSample
from shapegoogle_core.registration.sample import (
    SampleSettings,
    SurfaceSample,
    farthest_points,
    sample_surface,
)
from shapegoogle_core.registration.support import supports
from shapegoogle_core.registration.surface_fit import (
    Fit,
    Surface,
    TangentPlanes,
    fit_numbered,
    fit_surface,
    frame_between,
    mirrored,
)

__all__ = [
    "PART_SCALES",
    "SCALES",
    "SHARED_SCALES",
    "Alignment",
    "Fit",
    "Frame",
    "Isometry",
    "LocalSettings",
    "LocalWords",
    "PreparedSample",
    "RoughPose",
    "SampleSettings",
    "Surface",
    "SurfaceSample",
    "TangentPlanes",
    "align",
    "farthest_points",
    "fit_exactly",
    "fit_local_words",
    "fit_numbered",
    "fit_surface",
    "frame_between",
    "functional_map",
    "measure",
    "mirrored",
    "rough_pose",
    "sample_surface",
    "spectral_difference",
    "supports",
]
