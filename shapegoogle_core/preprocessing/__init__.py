# SPDX-License-Identifier: MIT
"""Preprocessing: repair, hole filling, resampling and smoothing before the Laplacian."""

from shapegoogle_core.preprocessing.fans import separate_fans
from shapegoogle_core.preprocessing.holes import close_holes
from shapegoogle_core.preprocessing.repair import repair, repair_mapped
from shapegoogle_core.preprocessing.resampling import resample
from shapegoogle_core.preprocessing.smoothing import smooth
from shapegoogle_core.preprocessing.steps import (
    Preprocessed,
    PreprocessingSettings,
    Unsmoothed,
    preprocess,
    preprocess_in_steps,
)

__all__ = [
    "Preprocessed",
    "PreprocessingSettings",
    "Unsmoothed",
    "close_holes",
    "preprocess",
    "preprocess_in_steps",
    "repair",
    "repair_mapped",
    "resample",
    "separate_fans",
    "smooth",
]
