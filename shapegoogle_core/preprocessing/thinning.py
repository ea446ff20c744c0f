# SPDX-License-Identifier: MIT
"""Bringing point clouds to a working resolution."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.preprocessing.grid import cell_numbers, finest_cell

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
    cell = finest_cell(
        float(position.max()),
        lambda cell: len(np.unique(cell_numbers(position, cell))),
        count,
        _GRID_STEPS,
    )
    _, group, sizes = np.unique(cell_numbers(position, cell), return_inverse=True, return_counts=True)
    return np.stack([np.bincount(group, axis) / sizes for axis in points.T], axis=1)
