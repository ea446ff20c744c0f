# SPDX-License-Identifier: MIT
"""Exact nearest points of a triangle mesh, whatever the shapes and sizes of its faces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["TriangleTree", "nearest_on_triangles"]

# Faces are cut into pieces that fit into balls of this radius, times the square root of the area per piece if
# there were so many.
_RADIUS = 1.2
_FEWEST_PIECES = 1_000
_MOST_PIECES = 60_000
# Pieces with the nearest centres that are tried first.
_FIRST = 6
# Factor of their number while others are not ruled out.
_GROWTH = 2
# Pairs of points and faces compared at once.
_AT_ONCE = 1 << 18


class TriangleTree:
    """Search tree of triangles.

    Long triangles are cut into short pieces, each in a ball. No piece whose ball is farther than the nearest
    point found so far can hold a nearer one, so the pieces with the nearest centres are tried first, and then
    all that are not ruled out.

    Parameters
    ----------
    triangles : (m, 3, 3) array
        Corners; at least one triangle. Triangles without area count as segments or points.
    """

    def __init__(self, triangles: FloatArray) -> None:
        self._triangles = np.asarray(triangles, np.float64)
        self._parents, self._centers, self._radii = _pieces(self._triangles)
        self._largest = float(self._radii.max())
        self._tree = cKDTree(self._centers)

    def near(self, points: FloatArray) -> tuple[FloatArray, NDArray[np.int64]]:
        """Find points of the triangles that are almost the nearest, many times faster than `nearest`.

        Parameters
        ----------
        points : (n, 3) array

        Returns
        -------
        near : (n, 3) array
            No farther than the nearest points by more than the size of a piece.
        faces : (n,) array of int
            Triangles on which they lie.
        """
        _, pieces = self._tree.query(points)
        return self._centers[pieces], self._parents[pieces]

    def nearest(self, points: FloatArray, reach: float = np.inf) -> tuple[FloatArray, NDArray[np.int64]]:
        """Find the nearest points of the triangles.

        Parameters
        ----------
        points : (n, 3) array
        reach : float, optional
            For points that are farther than this from all triangles `near` is good enough.

        Returns
        -------
        nearest : (n, 3) array
        faces : (n,) array of int
            Triangles on which they lie.
        """
        points = np.asarray(points, np.float64)
        away, pieces = self._tree.query(points)
        distances: FloatArray = np.asarray(away)
        nearest, faces = self._centers[pieces], self._parents[pieces]
        # The centre of a piece lies on its triangle, so it bounds the distance.
        rows = np.flatnonzero(distances <= reach + self._largest)
        reached, count = np.zeros(len(rows)), _FIRST
        while len(rows):
            count = min(count, len(self._parents))
            away, pieces = self._tree.query(points[rows], count)
            away = np.asarray(away).reshape(len(rows), -1)
            pieces = np.asarray(pieces).reshape(len(rows), -1)
            # Centres often coincide, so those at the distance that was reached are compared again.
            nearer = (away >= reached[:, None]) & (away - self._radii[pieces] < distances[rows, None])
            pair_rows = np.repeat(rows, nearer.sum(axis=1))
            pair_faces = self._parents[pieces[nearer]]
            for start in range(0, len(pair_rows), _AT_ONCE):
                row, face = pair_rows[start : start + _AT_ONCE], pair_faces[start : start + _AT_ONCE]
                found = nearest_on_triangles(self._triangles[face], points[row])
                apart = np.linalg.norm(found - points[row], axis=1)
                order = np.lexsort((apart, row))
                best = order[np.flatnonzero(np.diff(row[order], prepend=-1))]
                best = best[apart[best] < distances[row[best]]]
                here = row[best]
                nearest[here], faces[here], distances[here] = found[best], face[best], apart[best]
            if count == len(self._parents):
                break
            left = away[:, -1] < distances[rows] + self._largest
            rows, reached, count = rows[left], away[left, -1], _GROWTH * count
        return nearest, faces


def nearest_on_triangles(triangles: FloatArray, points: FloatArray) -> FloatArray:
    """Find the nearest point of the i-th triangle to the i-th point, for all i.

    Parameters
    ----------
    triangles : (n, 3, 3) array
    points : (n, 3) array

    Returns
    -------
    nearest : (n, 3) array
        The foot of the perpendicular if it lies inside, otherwise the nearest point of the three sides.
    """
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    sides = np.stack([b - a, c - b, a - c], axis=1)
    offsets = points[:, None] - triangles
    along = np.einsum("nsk,nsk->ns", offsets, sides)
    lengths = np.einsum("nsk,nsk->ns", sides, sides)
    share = np.clip(along / np.maximum(lengths, np.finfo(float).tiny), 0, 1)
    feet = triangles + share[:, :, None] * sides
    squared = ((points[:, None] - feet) ** 2).sum(axis=2)
    rows = np.arange(len(points))
    nearest = feet[rows, squared.argmin(axis=1)]
    normals = np.cross(sides[:, 0], -sides[:, 2])
    areas = np.einsum("nk,nk->n", normals, normals)
    # A point is over the triangle if it lies on the inner side of all three sides.
    over = (np.einsum("nsk,nsk->ns", np.cross(sides, offsets), normals[:, None]) >= 0).all(axis=1)
    over &= areas > 1e-24 * lengths.max(axis=1, initial=0.0) ** 2
    height = np.einsum("nk,nk->n", offsets[:, 0], normals)[over] / areas[over]
    nearest[over] = points[over] - height[:, None] * normals[over]
    return np.asarray(nearest)


def _pieces(triangles: FloatArray) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """Cut triangles across their longest sides until they are small: parents, and the balls around them."""
    doubled = np.linalg.norm(
        np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1
    )
    limit = _RADIUS * np.sqrt(doubled.sum() / 2 / max(_FEWEST_PIECES, len(triangles)))
    parent = np.arange(len(triangles))
    done: list[tuple[NDArray[np.int64], FloatArray, FloatArray]] = []
    finished = 0
    while True:
        sides = np.linalg.norm(triangles - np.roll(triangles, -1, axis=1), axis=2)
        longest = sides.argmax(axis=1)
        # Turned so that the longest side goes from the first corner to the second.
        order = (longest[:, None] + np.arange(3)) % 3
        triangles = np.take_along_axis(triangles, order[:, :, None], axis=1)
        middle = triangles[:, :2].mean(axis=1)
        radii = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
        large = radii > limit
        if finished + len(triangles) + np.count_nonzero(large) > _MOST_PIECES:
            large[:] = False
        done.append((parent[~large], middle[~large], radii[~large]))
        finished += int(np.count_nonzero(~large))
        if not large.any():
            parents, centers, sizes = (np.concatenate(parts) for parts in zip(*done, strict=True))
            return parents, centers, sizes
        corners, halves = triangles[large], middle[large]
        triangles = np.concatenate(
            [
                np.stack([corners[:, 0], halves, corners[:, 2]], axis=1),
                np.stack([halves, corners[:, 1], corners[:, 2]], axis=1),
            ]
        )
        parent = np.tile(parent[large], 2)
