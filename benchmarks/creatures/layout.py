# SPDX-License-Identifier: MIT
"""Helpers for the positions of joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["between", "offset"]

FloatArray = NDArray[np.float64]


def between(start: ArrayLike, end: ArrayLike, segments: int) -> FloatArray:
    """Return evenly spaced points from start to end, (segments + 1, 3), or evenly spaced numbers."""
    return np.linspace(np.asarray(start, float), np.asarray(end, float), segments + 1)


def offset(point: ArrayLike, x: float, y: float, z: float) -> FloatArray:
    """Return the point at the offset (x, y, z) from `point`."""
    moved: FloatArray = np.asarray(point, float) + np.array([x, y, z], float)
    return moved
