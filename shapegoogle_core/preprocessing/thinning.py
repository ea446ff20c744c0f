# SPDX-License-Identifier: MIT
"""Bringing point clouds to a working resolution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["thin"]

_GRID_STEPS = 18  # of bisection: the cell to 1e-5 of the longest side


def thin(points: FloatArray, count: int) -> FloatArray:
    """Thin points to `count` at most, about equally dense everywhere: the mean in each cell of a grid.

    The grid is about the finest one that leaves no more. Means have less noise than the points.

    Parameters
    ----------
    points : (n, 3) array
    count : int
        Most points.

    Returns
    -------
    thinned : (m, 3) array
        m ≤ count. The array itself if it has no more points.
    """
    if len(points) <= count:
        return points
    position = points - points.min(axis=0)
    too_small, cell = 0.0, 2 * float(position.max())  # the larger holds everything
    for _ in range(_GRID_STEPS):
        middle = (too_small + cell) / 2
        if len(np.unique(_cells(position, middle))) <= count:
            cell = middle
        else:
            too_small = middle
    _, group, sizes = np.unique(_cells(position, cell), return_inverse=True, return_counts=True)
    return np.stack([np.bincount(group, axis) / sizes for axis in points.T], axis=1)


def _cells(position: FloatArray, cell: float) -> NDArray[np.int64]:
    """Cell of each point of a grid that begins at 0, as one number."""
    x, y, z = (position / cell).astype(np.int64).T
    side = 1 << _GRID_STEPS
    return np.asarray((x * side + y) * side + z)
