# SPDX-License-Identifier: MIT
"""Preprocessing: repair, hole filling, resampling and smoothing before the Laplacian."""

from shapegoogle_core.preprocessing.holes import close_holes
from shapegoogle_core.preprocessing.preprocess import Mending, mend, mend_cloud
from shapegoogle_core.preprocessing.repair import repair, repair_mapped
from shapegoogle_core.preprocessing.resampling import resample
from shapegoogle_core.preprocessing.smoothing import smooth

__all__ = ["Mending", "close_holes", "mend", "mend_cloud", "repair", "repair_mapped", "resample", "smooth"]
