# SPDX-License-Identifier: MIT
"""Spin images: what the surface around a point looks like in space (Johnson and Hebert 1999)."""

from __future__ import annotations

import math

import numpy as np

from shapegoogle_core.descriptors.checks import check_bins, check_radius, chunks
from shapegoogle_core.mesh.measures import vertex_areas, vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["spin_images", "vertex_spin_images"]

# So many images at a time: the coordinates of the cloud as each point sees it stay in the processor's cache.
_TOGETHER = 100


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


def vertex_spin_images(mesh: Mesh, radius: float = 0.4, bins: tuple[int, int] = (8, 4)) -> FloatArray:
    """Spin image of every vertex of a surface (paper, section 3.2; Johnson and Hebert 1999).

    Parameters
    ----------
    mesh : Mesh
    radius : float
        Of the support, as a share of the root of the surface's area.
    bins : (int, int)
        In the distance to the normal through the vertex, and in the height over its tangent plane.

    Returns
    -------
    images : (n, bins) array
        Share of the area inside the support that each bin of `spin_images` holds; a row sums to 1.

    Raises
    ------
    ValueError
        If the radius is not positive or there are no bins.
    """
    check_radius(radius)
    check_bins("bins", *bins)
    unit = math.sqrt(mesh.area)
    points, normals, areas = mesh.vertices / unit, vertex_normals(mesh), vertex_areas(mesh)
    images = np.concatenate(
        [
            spin_images(points[chunk], normals[chunk], points, areas, radius, bins)
            for chunk in chunks(len(points), _TOGETHER)
        ]
    )
    return np.asarray(images / images.sum(axis=1, keepdims=True))
