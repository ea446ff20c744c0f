# SPDX-License-Identifier: MIT
"""Geometry of point clouds, the points that scanners measure of a surface."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["point_normals"]

_NEIGHBOURS = 16


def point_normals(points: FloatArray) -> FloatArray:
    """Compute the normals of the planes that best fit the neighbours of each point (Hoppe et al. 1992).

    Parameters
    ----------
    points : (n, 3) array

    Returns
    -------
    normals : (n, 3) array
        Directions of least variance, of unit length; their sign is arbitrary.
    """
    _, near = KDTree(points).query(points, min(_NEIGHBOURS, len(points)))
    offsets = points[near] - points[near].mean(axis=1, keepdims=True)
    _, directions = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))
    return np.ascontiguousarray(directions[:, :, 0])
