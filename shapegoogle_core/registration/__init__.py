# SPDX-License-Identifier: MIT
"""Laying one surface over another: what a match has in common with the query, in space."""

from shapegoogle_core.registration.alignment import Alignment, Placed, align
from shapegoogle_core.registration.local_words import LocalSettings, LocalWords, fit_local_words
from shapegoogle_core.registration.sample import SampleSettings, SurfaceSample, sample_surface
from shapegoogle_core.registration.screening import supports

__all__ = [
    "Alignment",
    "LocalSettings",
    "LocalWords",
    "Placed",
    "SampleSettings",
    "SurfaceSample",
    "align",
    "fit_local_words",
    "sample_surface",
    "supports",
]
