# SPDX-License-Identifier: MIT
"""Helpers for the positions of joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["between", "offset"]

FloatArray = NDArray[np.float64]


def between(start: ArrayLike, end: ArrayLike, segments: int) -> FloatArray:
    """Return evenly spaced points, or numbers, from start to end.

    Parameters
    ----------
    start, end : (3,) array_like or float
    segments : int

    Returns
    -------
    points : (segments + 1, 3) or (segments + 1,) array
    """
    return np.linspace(np.asarray(start, float), np.asarray(end, float), segments + 1)


def offset(point: ArrayLike, x: float, y: float, z: float) -> FloatArray:
    """Translate a point.

    Parameters
    ----------
    point : (3,) array_like
    x, y, z : float

    Returns
    -------
    moved : (3,) array
    """
    moved: FloatArray = np.asarray(point, float) + np.array([x, y, z], float)
    return moved
