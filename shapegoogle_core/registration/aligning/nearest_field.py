# SPDX-License-Identifier: MIT
"""`NearestField`: a voxel grid around points that knows the nearest of them, for very many look-ups.

A search tree takes a microsecond for each query point. Alignments of a query with many candidates look up
millions of points around the same few hundred, for which a grid is ten times as fast.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["NearestField"]

# Size of a voxel and largest distance of an answer, in units of √area. Samples have a spacing of 0.04.
_VOXEL, _REACH = 0.03, 0.12
# At most this many voxels: samples that are spread wider get larger ones.
_MOST_VOXELS = 400_000
# Where the point lies that stands for "none within reach".
_NOWHERE = 1e3


class NearestField:
    """Nearest of some points, exact for the middle of each voxel.

    Parameters
    ----------
    points : (m, 3) array

    Attributes
    ----------
    points : (m + 1, 3) array of float32
        The points, and one that is far away from everything: the answer where none is within reach.
    """

    def __init__(self, points: FloatArray) -> None:
        low, high = points.min(axis=0) - _REACH, points.max(axis=0) + _REACH
        voxel = max(_VOXEL, float(np.prod(high - low) / _MOST_VOXELS) ** (1 / 3))
        shape = np.ceil((high - low) / voxel).astype(np.int32)
        near = np.argwhere(_within_reach(points, low, voxel, shape))
        # A search tree takes longer to find that nothing is near than to find what is.
        nearest = np.full(shape, len(points), np.int32)
        _, found = cKDTree(points).query(low + voxel * (near + 0.5), distance_upper_bound=_REACH)
        nearest[tuple(near.T)] = found
        self.points: NDArray[np.float32] = np.concatenate([points, np.full((1, 3), _NOWHERE)]).astype(
            np.float32
        )
        # A border of one voxel, in which nothing is near, takes everything outside.
        grid = np.full(shape + 2, len(points), np.int32)
        grid[1:-1, 1:-1, 1:-1] = nearest
        self._grid = grid.ravel()
        self._last = (shape + 1).astype(np.float32)
        self._strides = np.array([grid.shape[1] * grid.shape[2], grid.shape[2], 1], np.int32)
        self._origin = (low - voxel).astype(np.float32)
        self._per_unit = np.float32(1 / voxel)

    def nearest(self, places: NDArray[np.float32]) -> NDArray[np.int32]:
        """Look up the nearest points.

        Parameters
        ----------
        places : (..., 3) array of float32

        Returns
        -------
        nearest : (...) array of int32
            Indices of `points`.
        """
        # Axis by axis: numpy is slow where the innermost of its loops has three steps.
        voxels = np.zeros(places.shape[:-1], np.int32)
        for axis in range(3):
            cells = places[..., axis] - self._origin[axis]
            cells *= self._per_unit
            np.clip(cells, 0, self._last[axis], out=cells)
            voxels += cells.astype(np.int32) * self._strides[axis]
        return self._grid.take(voxels)


def _within_reach(
    points: FloatArray, low: FloatArray, voxel: float, shape: NDArray[np.int32]
) -> NDArray[np.bool_]:
    """Mark the voxels around points; all whose middles are within reach of one are among them."""
    marked = np.zeros(shape, bool)
    marked[tuple(((points - low) / voxel).astype(int).T)] = True
    steps = int(_REACH / voxel + 0.5 + 1e-6)
    for axis in range(3):
        before = np.moveaxis(marked.copy(), axis, 0)
        after = np.moveaxis(marked, axis, 0)
        for step in range(1, steps + 1):
            after[step:] |= before[:-step]
            after[:-step] |= before[step:]
    return marked
