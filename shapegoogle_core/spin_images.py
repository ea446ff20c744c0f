# SPDX-License-Identifier: MIT
"""Spin images: what the surface around a point looks like in space (Johnson and Hebert 1999)."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["spin_images"]


def spin_images(
    points: FloatArray,
    normals: FloatArray,
    cloud: FloatArray,
    weights: FloatArray,
    radius: float,
    bins: tuple[int, int],
) -> FloatArray:
    """Histograms of a surface in the cylindrical coordinates of each of some oriented points.

    Of every point x of the cloud, α is the distance to the axis through p along its normal n, and β the
    height over the tangent plane: β = n · (x - p), α² = ‖x - p‖² - β². A rotation about the axis changes
    neither. The height is taken without its sign, as the normals of many meshes point to either side.

    Parameters
    ----------
    points, normals : (k, 3) arrays
        Normals of unit length.
    cloud : (n, 3) array
    weights : (n,) array
        What each point of the cloud counts: the area that it stands for, say.
    radius : float
        Of the support, in the unit of the points: 0 ≤ α < radius, 0 ≤ |β| < radius.
    bins : (int, int)
        In α and in β.

    Returns
    -------
    images : (k, bins) array
        The weight of the cloud in each bin, flattened; a row's sum is the weight inside the support.
    """
    heights = np.abs(normals @ cloud.T - (normals * points).sum(axis=1)[:, None])
    squares = (cloud**2).sum(axis=1) + (points**2).sum(axis=1)[:, None] - 2 * points @ cloud.T
    distances = np.sqrt(np.maximum(squares - heights**2, 0))
    rows, columns = bins
    inside = (distances < radius) & (heights < radius)
    row = (distances[inside] * (rows / radius)).astype(np.int64)
    column = (heights[inside] * (columns / radius)).astype(np.int64)
    image, point = np.nonzero(inside)
    cell = (image * rows + np.minimum(row, rows - 1)) * columns + np.minimum(column, columns - 1)
    summed = np.bincount(cell, weights[point], minlength=len(points) * rows * columns)
    return np.asarray(summed.reshape(len(points), -1), dtype=np.float64)
