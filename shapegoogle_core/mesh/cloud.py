# SPDX-License-Identifier: MIT
"""Point clouds: what scanners measure of a surface, without faces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["point_normals", "thin"]

_GRID_STEPS = 18  # of bisection: the cell to 1e-5 of the longest side
_NEIGHBOURS = 16


def thin(points: FloatArray, count: int) -> FloatArray:
    """Bring points to `count` at most, about as dense everywhere: the mean in each cell of a grid.

    The grid is about the finest one that leaves no more. Means have less noise than the points.

    Parameters
    ----------
    points : (n, 3) array
    count : int

    Returns
    -------
    thinned : (m, 3) array
        m ≤ count; all points as they are, if there are no more.
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


def point_normals(points: FloatArray) -> FloatArray:
    """Take the normals of the planes that fit the neighbours of each point best (Hoppe et al. 1992).

    Parameters
    ----------
    points : (n, 3) array

    Returns
    -------
    normals : (n, 3) array
        Directions of least variance, of unit length; which side they are on means nothing.
    """
    _, near = KDTree(points).query(points, min(_NEIGHBOURS, len(points)))
    offsets = points[near] - points[near].mean(axis=1, keepdims=True)
    _, directions = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))
    return np.ascontiguousarray(directions[:, :, 0])
