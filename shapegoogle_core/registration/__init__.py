# SPDX-License-Identifier: MIT
"""Laying one surface over another: what a match has in common with the query, in space."""

from shapegoogle_core.registration.alignment import Alignment, Placed, align, support
from shapegoogle_core.registration.sample import SampleSettings, SurfaceSample, sample_surface

__all__ = ["Alignment", "Placed", "SampleSettings", "SurfaceSample", "align", "sample_surface", "support"]
