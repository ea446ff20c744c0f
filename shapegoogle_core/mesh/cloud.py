# SPDX-License-Identifier: MIT
"""Point clouds: what scanners measure of a surface, without faces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["FEWEST_POINTS", "check_cloud", "point_normals", "thin"]

FEWEST_POINTS = 10
"""Fewer points than these are no shape."""

# A cloud that is thinner in two directions than this share of its extent is a line.
_LEAST_WIDTH = 1e-6
_GRID_STEPS = 18  # of bisection: the cell to 1e-5 of the longest side
_NEIGHBOURS = 16


def check_cloud(mesh: Mesh) -> None:
    """Raise unless points without faces can be described.

    Parameters
    ----------
    mesh : Mesh
        Faces, if there are any, are not looked at.

    Raises
    ------
    MeshError
        If there are fewer than ten different points, all lie on a line, or the coordinates are so large or
        small that areas leave the range of floating-point numbers.
    """
    count = len(np.unique(mesh.vertices, axis=0))
    if count < FEWEST_POINTS:
        different = "" if count == len(mesh.vertices) else f", {count} of them at different places"
        raise MeshError(
            f"{mesh.name!r} has no faces and {len(mesh.vertices)} points{different}; a point cloud needs at "
            f"least {FEWEST_POINTS}, a mesh its faces: export it again"
        )
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        extent = np.ptp(mesh.vertices, axis=0).max()
        area = extent**2
    if not 0 < area < np.inf:
        raise MeshError(
            f"{mesh.name!r} is {extent:g} units long, so that areas leave the range of numbers; "
            "scale the points to a usual size"
        )
    centered = (mesh.vertices - mesh.vertices.mean(axis=0)) / extent
    widths = np.sqrt(np.maximum(np.linalg.eigvalsh(centered.T @ centered / len(centered)), 0))
    if widths[1] < max(_LEAST_WIDTH, 8 * np.finfo(float).eps * np.abs(mesh.vertices).max() / extent):
        raise MeshError(f"{mesh.name!r}: all its points lie on a line; a shape needs points of a surface")


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
