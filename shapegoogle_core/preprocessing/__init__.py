# SPDX-License-Identifier: MIT
"""Preprocessing: repair, hole filling, resampling and smoothing before the Laplacian."""

from shapegoogle_core.preprocessing.fans import separate_fans
from shapegoogle_core.preprocessing.holes import close_holes
from shapegoogle_core.preprocessing.repair import repair, repair_mapped
from shapegoogle_core.preprocessing.resampling import resample
from shapegoogle_core.preprocessing.smoothing import smooth
from shapegoogle_core.preprocessing.steps import PreprocessingSettings, preprocess

__all__ = [
    "PreprocessingSettings",
    "close_holes",
    "preprocess",
    "repair",
    "repair_mapped",
    "resample",
    "separate_fans",
    "smooth",
]
