# SPDX-License-Identifier: MIT
"""Distances between all points of a set."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["point_distances"]


def point_distances(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Compute the distances between all points of each set.

    Parameters
    ----------
    points : (..., n, 3) array of float32

    Returns
    -------
    distances : (..., n, n) array of float32
        By one matrix product: fast, and exact to the square root of the rounding error.
    """
    squares = np.einsum("...i,...i->...", points, points)
    squared = squares[..., :, None] + squares[..., None, :]
    squared -= 2 * points @ points.swapaxes(-1, -2)
    return np.asarray(np.sqrt(np.maximum(squared, 0, out=squared), out=squared))
