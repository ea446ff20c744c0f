# SPDX-License-Identifier: MIT
"""Spin images, histograms of the surface around a point in space (paper, section 3.2)."""

from __future__ import annotations

import math

import numpy as np

from shapegoogle_core.descriptors.checks import check_bins, check_radius, chunks
from shapegoogle_core.mesh import MeshLike, clean_surface
from shapegoogle_core.mesh.measures import vertex_areas, vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["spin_images", "vertex_spin_images"]

# Number of images at a time, so that the coordinates of the cloud about each point stay in the processor's
# cache.
_TOGETHER = 100


def spin_images(
    points: FloatArray,
    normals: FloatArray,
    cloud: FloatArray,
    weights: FloatArray,
    radius: float,
    bins: tuple[int, int],
) -> FloatArray:
    """Histograms of a surface in the cylindrical coordinates of oriented points (Johnson and Hebert 1999).

    For each point x of the cloud, α is the distance to the axis through p along its normal n, and β the
    height over the tangent plane: β = n · (x - p), α² = ‖x - p‖² - β². A rotation about the axis changes
    neither. The height is taken without its sign, as the normals of many meshes point to either side.

    Parameters
    ----------
    points, normals : (k, 3) arrays
        Oriented points p; the normals n have unit length.
    cloud : (n, 3) array
        Points x of the surface.
    weights : (n,) array
        Weight of each point of the cloud, for example the area that it represents.
    radius : float
        Radius of the support, in the unit of the points: 0 ≤ α < radius, 0 ≤ |β| < radius.
    bins : (int, int)
        Numbers of bins in α and in β.

    Returns
    -------
    images : (k, bins) array
        Weight of the cloud in each bin, flattened; a row sums to the weight inside the support.
    """
    heights = normals @ cloud.T
    heights -= (normals * points).sum(axis=1)[:, None]
    np.abs(heights, out=heights)
    squares = (cloud**2).sum(axis=1) + (points**2).sum(axis=1)[:, None]
    squares -= 2 * points @ cloud.T
    squares -= heights * heights
    rows, columns = bins
    # Most points are outside, so roots are taken of the others only.
    places = np.flatnonzero((heights < radius) & (squares < radius**2))
    heights, squares = heights.ravel()[places], squares.ravel()[places]
    row = (np.sqrt(np.maximum(squares, 0)) * (rows / radius)).astype(np.int64)
    column = (heights * (columns / radius)).astype(np.int64)
    image, point = np.divmod(places, len(cloud))
    cell = (image * rows + np.minimum(row, rows - 1)) * columns + np.minimum(column, columns - 1)
    summed = np.bincount(cell, weights[point], minlength=len(points) * rows * columns)
    return np.asarray(summed.reshape(len(points), -1), dtype=np.float64)


def vertex_spin_images(mesh: MeshLike, radius: float = 0.4, bins: tuple[int, int] = (8, 4)) -> FloatArray:
    """Spin image of every vertex of a surface (paper, section 3.2; Johnson and Hebert 1999).

    Parameters
    ----------
    mesh : MeshLike
        A mesh of triangles.
    radius : float
        Radius of the support, as a share of the square root of the surface's area.
    bins : (int, int)
        Numbers of bins in the distance to the normal through the vertex, and in the height over its tangent
        plane.

    Returns
    -------
    images : (n, bins) array
        Share of the area inside the support in each bin of `spin_images`; a row sums to 1.

    Raises
    ------
    ValueError
        If the radius is not positive or there are no bins.
    MeshError
        If the shape is not a surface, or a vertex has no area.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> mesh = sg.Mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    >>> images = sg.vertex_spin_images(mesh, radius=0.8, bins=(2, 2))
    >>> images[0].round(3).tolist()  # the vertex itself, and the three others on a ring around its normal
    [0.25, 0.0, 0.0, 0.75]
    """
    mesh = clean_surface(mesh)
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
