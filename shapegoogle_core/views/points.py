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
from shapegoogle_core.mesh.connectivity import used_points
from shapegoogle_core.mesh.measures import cross_products, face_blocks

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
    vertices, faces = _moderate(mesh.vertices), mesh.faces
    doubled = np.empty(len(faces))
    for block, (a, b, c) in face_blocks(vertices, faces):
        normals = np.ascontiguousarray(cross_products(b - a, c - a).T)
        doubled[block] = np.sqrt(np.einsum("nd,nd->n", normals, normals))
    # Slivers that are only rounding errors have no direction, and no part of the area.
    solid = np.flatnonzero(doubled > 1e-14 * doubled.max(initial=0))
    if len(solid) == 0:
        corner_points = fit_into_ball(vertices[faces].reshape(-1, 3)).astype(np.float32)
        return corner_points, np.zeros_like(corner_points)
    ends = np.cumsum(doubled[solid])
    # Of each face as many points as steps of a ruler along all areas begin inside it.
    begun = np.floor(ends * (count / ends[-1]) + 0.5).astype(np.intp)
    each = np.diff(begun, prepend=0)
    chosen, each = solid[each > 0], each[each > 0]
    a, b, c = vertices[faces[chosen].T]
    directions = cross_products(b - a, c - a) / doubled[chosen]
    solid_faces = faces if len(solid) == len(faces) else faces[solid]
    center, reach = _ball(used_points(vertices, solid_faces).T)
    a, b, c = ((corner - center) / reach for corner in (a, b, c))
    start, along, across, normal = (
        side.astype(np.float32, order="C").repeat(each, axis=1)
        for side in (a.T, (b - a).T, (c - a).T, directions)
    )
    one, two = _spread_weights(count)[:, : start.shape[1]]
    return (start + along * one + across * two).T, normal.T


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
    columns = np.ascontiguousarray(points.T)
    center, reach = _ball(columns)
    centred = columns - center[:, None]
    return np.asarray(centred / reach if reach > 0 else centred).T


def _ball(columns: NDArray[_Real]) -> tuple[NDArray[_Real], _Real]:
    """Find the middle of the bounding box of points (3, n), and the distance of the farthest from it."""
    center = (columns.min(axis=1) + columns.max(axis=1)) / 2
    x, y, z = columns - center[:, None]
    return center, np.sqrt((x * x + y * y + z * z).max())


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
