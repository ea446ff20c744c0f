# SPDX-License-Identifier: MIT
"""Alignment of two surfaces: the motion that brings one onto the other, and how much of each is covered."""

from shapegoogle_core.registration.alignment import Alignment, PreparedSample, align
from shapegoogle_core.registration.local_words import LocalSettings, LocalWords, fit_local_words
from shapegoogle_core.registration.sample import SampleSettings, SurfaceSample, sample_surface
from shapegoogle_core.registration.support import supports

__all__ = [
    "Alignment",
    "LocalSettings",
    "LocalWords",
    "PreparedSample",
    "SampleSettings",
    "SurfaceSample",
    "align",
    "fit_local_words",
    "sample_surface",
    "supports",
]
