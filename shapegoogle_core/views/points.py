# SPDX-License-Identifier: MIT
"""Points all over a surface, with normals: what pictures are drawn from.

Points need no closed surface, no manifold edges and no orientation, and a shape of many faces takes no longer
than one of few.
"""

from __future__ import annotations

from functools import cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh import MeshLike, as_mesh

__all__ = ["fit_into_ball", "surface_points"]

FloatArray = NDArray[np.float64]
Points = NDArray[np.float32]
_Real = TypeVar("_Real", np.float32, np.float64)

# Steps of a sequence that fills the unit square evenly (the plastic number's powers).
_PLASTIC = 1.324717957244746
_STEPS = np.array([1 / _PLASTIC, 1 / _PLASTIC**2])
# Nearest points of a cloud that its tangent plane is fitted to.
_NEIGHBOURS = 12


def surface_points(mesh: MeshLike, count: int) -> tuple[Points, Points]:
    """Spread points evenly over a shape, in the ball of radius 1 around the middle of its bounding box.

    The same mesh gives the same points.

    Parameters
    ----------
    mesh : MeshLike
        In any state. Of a point cloud the points are spread in the tangent planes; of a mesh without area,
        they are its corners.
    count : int
        Number of points.

    Returns
    -------
    points : (n, 3) array of float32
        About `count`; none for a mesh without vertices.
    normals : (n, 3) array of float32
        Of unit length, or zero where there is none. Their signs mean nothing.

    Examples
    --------
    >>> import trimesh
    >>> from shapegoogle_core.views import surface_points
    >>> points, normals = surface_points(trimesh.creation.box((1, 2, 3)), 1_000)
    >>> points.shape, float(abs(points[:, 2]).max()).__round__(2)
    ((1000, 3), 0.8)
    """
    mesh = as_mesh(mesh)
    if mesh.is_point_cloud:
        discs, axes = _cloud_points(fit_into_ball(_moderate(mesh.vertices)), count)
        return discs.astype(np.float32), axes.astype(np.float32)
    corners = _moderate(mesh.vertices)[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.sqrt(np.einsum("nd,nd->n", normals, normals))
    # Slivers that are only rounding errors have no direction, and no part of the area.
    solid = doubled > 1e-14 * doubled.max(initial=0)
    if not solid.any():
        corner_points = fit_into_ball(corners.reshape(-1, 3)).astype(np.float32)
        return corner_points, np.zeros_like(corner_points)
    corners, directions, doubled = corners[solid], normals[solid] / doubled[solid, None], doubled[solid]
    corners = np.ascontiguousarray(fit_into_ball(corners.reshape(-1, 3))).reshape(-1, 3, 3)
    ends = np.cumsum(doubled)
    # Of each face as many points as steps of a ruler along all areas begin inside it.
    begun = np.floor(ends * (count / ends[-1]) + 0.5).astype(np.intp)
    face = np.repeat(np.arange(len(ends)), np.diff(begun, prepend=0))
    one, two = _spread_weights(count)[:, : len(face)]
    start, along, across = (
        _taken(side, face)
        for side in (corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    )
    points = np.asarray(start + along * one + across * two, np.float32)
    return points.T, _taken(directions, face).T


def _taken(rows: FloatArray, numbers: NDArray[np.intp]) -> Points:
    """Take rows of an array (n, 3) as columns: equal coordinates side by side are faster to compute with."""
    return np.ascontiguousarray(rows.T, np.float32).take(numbers, axis=1)


@cache
def _spread_weights(count: int) -> Points:
    """Weights (2, count) of the second and third corner of a triangle that spread points evenly over it."""
    first, second = (np.arange(1, count + 1)[:, None] * _STEPS % 1).T
    root = np.sqrt(first)
    weights = np.stack([root * (1 - second), root * second]).astype(np.float32)
    weights.setflags(write=False)
    return weights


def fit_into_ball(points: NDArray[_Real]) -> NDArray[_Real]:
    """Move the middle of the bounding box to the origin, and scale the farthest point to distance 1.

    Parameters
    ----------
    points : (n, 3) array

    Returns
    -------
    points : (n, 3) array
        Zeros if all points are the same.
    """
    if len(points) == 0:
        return points
    rows = np.ascontiguousarray(points.T)
    centred = rows - (rows.min(axis=1) + rows.max(axis=1))[:, None] / 2
    reach = np.sqrt((centred * centred).sum(axis=0).max())
    return np.asarray(centred / reach if reach > 0 else centred).T


def _moderate(points: FloatArray) -> FloatArray:
    """Scale coordinates so that none overflows when it is squared."""
    largest = np.abs(points).max(initial=0)
    return np.asarray(points / largest if largest > 0 else points)


def _cloud_points(points: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Spread points in discs around the points of a cloud, in their tangent planes."""
    # Imported here, because only clouds need it.
    from scipy.spatial import cKDTree

    if len(points) > count:
        points = points[(np.arange(count) * (len(points) / count)).astype(np.intp)]
    if len(points) < 4:
        return points, np.zeros_like(points)
    found = cKDTree(points).query(points, min(_NEIGHBOURS, len(points)))
    near, index = np.asarray(found[0]), np.asarray(found[1])
    around = points[index] - points[index].mean(axis=1, keepdims=True)
    axes = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1]
    each = -(-count // len(points))
    # A sunflower: discs of the size of the gaps, filled evenly.
    turn = np.arange(each) * np.pi * (3 - np.sqrt(5))
    radius = np.sqrt((np.arange(each) + 0.5) / each)
    offsets = radius[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    # The distance to the fourth nearest is about that to the next neighbours on all sides.
    reach = near[:, min(4, near.shape[1] - 1)]
    spread = np.einsum("ek,ndk->ned", offsets, axes[:, :, 1:]) * reach[:, None, None]
    filled = (points[:, None] + spread).reshape(-1, 3)
    return filled, np.repeat(axes[:, :, 0], each, axis=0)
