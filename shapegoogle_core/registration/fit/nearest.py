# SPDX-License-Identifier: MIT
"""Exact nearest points of a triangle mesh, whatever the shapes and sizes of its faces."""

from __future__ import annotations

from dataclasses import dataclass

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
_FIRST = 12
# Factor of their number while others are not ruled out.
_GROWTH = 3
# Lower bounds of distances are lowered by this share of the largest coordinate, for rounding errors.
_ROUNDING = 1e-9
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

    Attributes
    ----------
    normals : (m, 3) array
        Unit normals; those of triangles without area are 0, or shorter and of any direction.
    largest : float
        Radius of the largest piece: how far the answers of `near` may be off.
    """

    def __init__(self, triangles: FloatArray) -> None:
        self._triangles = np.asarray(triangles, np.float64)
        self._parents, self._centers, self._radii = _pieces(self._triangles)
        self.largest = float(self._radii.max())
        self._places = np.ascontiguousarray(self._centers.T)
        a, b, c = self._triangles.transpose(1, 2, 0)
        normals = _crossed(b - a, c - a).T
        self.normals = normals / np.maximum(_lengths(normals), np.finfo(float).tiny)[:, None]
        self._directions = np.ascontiguousarray(self.normals[self._parents].T)
        self._rounding = _ROUNDING * float(np.abs(self._triangles).max())
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
        count = min(_FIRST, len(self._parents))
        away, pieces = self._centers_near(points, count)
        found = _Found(self._centers[pieces[:, 0]], self._parents[pieces[:, 0]], away[:, 0].copy())
        # The centre of a piece lies on its triangle, so it bounds the distance.
        rows = np.flatnonzero(found.distances <= reach + self.largest)
        away, pieces, known = away[rows], pieces[rows], 0
        while len(rows):
            self._compare(points, found, rows, away[:, known:], pieces[:, known:])
            if count == len(self._parents):
                break
            left = away[:, -1] < found.distances[rows] + self.largest
            rows, reached = rows[left], away[left, -1]
            count = min(_GROWTH * count, len(self._parents))
            away, pieces = self._centers_near(points[rows], count)
            # Centres often coincide, so those at the distance that was reached are compared again.
            known = int((away < reached[:, None]).sum(axis=1).min(initial=count))
        return found.points, found.faces

    def _centers_near(self, points: FloatArray, count: int) -> tuple[FloatArray, NDArray[np.int64]]:
        """Return the distances and numbers, (n, count) each, of the pieces with the nearest centres."""
        away, pieces = self._tree.query(points, count)
        return np.asarray(away).reshape(len(points), count), np.asarray(pieces).reshape(len(points), count)

    def _compare(
        self,
        points: FloatArray,
        found: _Found,
        rows: NDArray[np.intp],
        away: FloatArray,
        pieces: NDArray[np.int64],
    ) -> None:
        """Compare points with pieces: with the one that seems nearest, then with those that may be nearer."""
        places, numbers = np.nonzero(away < found.distances[rows, None] + self.largest)
        some, apart = pieces[places, numbers], away[places, numbers]
        rows = rows[places]
        squares = np.zeros(len(rows))
        for axis in range(3):
            offsets = points[:, axis].take(rows) - self._places[axis].take(some)
            squares += offsets * self._directions[axis].take(some)
        squares *= squares
        # A piece lies in its plane, in a disc around its centre.
        aside = np.maximum(np.sqrt(np.maximum(apart**2 - squares, 0)) - self._radii.take(some), 0)
        bounds = np.sqrt(squares + aside**2) - self._rounding
        order = np.lexsort((bounds, rows))
        first = order[np.flatnonzero(np.diff(rows[order], prepend=-1))]
        limits = found.distances.copy()
        here, guessed = rows[first], self._parents[some[first]]
        feet = nearest_on_triangles(self._triangles[guessed], points[here])
        limits[here] = np.minimum(limits[here], _lengths(feet - points[here]))
        # Those at the same distance too: of two faces that meet there the first one counts.
        nearer = np.flatnonzero(bounds <= limits[rows])
        for start in range(0, len(nearer), _AT_ONCE):
            part = nearer[start : start + _AT_ONCE]
            faces = self._parents[some[part]]
            found.improve(points, rows[part], faces, self._triangles[faces])


@dataclass(frozen=True, eq=False)
class _Found:
    """Nearest points found so far.

    Attributes
    ----------
    points : (n, 3) array
    faces : (n,) array of int
    distances : (n,) array
    """

    points: FloatArray
    faces: NDArray[np.int64]
    distances: FloatArray

    def improve(
        self, asked: FloatArray, rows: NDArray[np.intp], faces: NDArray[np.int64], triangles: FloatArray
    ) -> None:
        """Compare points with triangles; `rows` is sorted, and may name a point several times."""
        feet = nearest_on_triangles(triangles, asked[rows])
        apart = _lengths(feet - asked[rows])
        order = np.lexsort((apart, rows))
        best = order[np.flatnonzero(np.diff(rows[order], prepend=-1))]
        best = best[apart[best] < self.distances[rows[best]]]
        here = rows[best]
        self.points[here], self.faces[here], self.distances[here] = feet[best], faces[best], apart[best]


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
    # Coordinates first: numpy is slow where the innermost of its loops has three steps.
    corners = np.ascontiguousarray(triangles.transpose(1, 2, 0))
    places = np.ascontiguousarray(points.T)
    sides = corners[[1, 2, 0]] - corners
    offsets = places - corners
    along, lengths = (offsets * sides).sum(axis=1), (sides * sides).sum(axis=1)
    share = np.clip(along / np.maximum(lengths, np.finfo(float).tiny), 0, 1)
    feet = corners + share[:, None] * sides
    side = ((places - feet) ** 2).sum(axis=1).argmin(axis=0)
    nearest = feet[side, :, np.arange(len(points))]
    normals = _crossed(sides[0], -sides[2])
    areas = (normals * normals).sum(axis=0)
    # A point is over the triangle if it lies on the inner side of all three sides.
    over = areas > 1e-24 * lengths.max(axis=0, initial=0.0) ** 2
    for edge, offset in zip(sides, offsets, strict=True):
        over &= (_crossed(edge, offset) * normals).sum(axis=0) >= 0
    heights = (offsets[0] * normals).sum(axis=0)[over] / areas[over]
    nearest[over] = (places[:, over] - heights * normals[:, over]).T
    return np.asarray(nearest)


def _lengths(vectors: FloatArray) -> FloatArray:
    """Return the lengths of the rows of an (n, 3) array."""
    x, y, z = vectors.T
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def _crossed(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cross products of the columns of two (3, n) arrays."""
    (a, b, c), (d, e, f) = first, second
    return np.stack([b * f - c * e, c * d - a * f, a * e - b * d])


def _pieces(triangles: FloatArray) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """Cut triangles across their longest sides until they are small: parents, and the balls around them."""
    # Coordinates first, as in `nearest_on_triangles`.
    corners = np.ascontiguousarray(triangles.transpose(1, 2, 0))
    doubled = np.sqrt((_crossed(corners[1] - corners[0], corners[2] - corners[0]) ** 2).sum(axis=0))
    limit = _RADIUS * np.sqrt(doubled.sum() / 2 / max(_FEWEST_PIECES, len(triangles)))
    parent = np.arange(len(triangles))
    done: list[tuple[NDArray[np.int64], FloatArray, FloatArray]] = []
    finished = 0
    while True:
        longest = ((corners - corners[[1, 2, 0]]) ** 2).sum(axis=1).argmax(axis=0)
        # Turned so that the longest side goes from the first corner to the second.
        order = (longest + np.arange(3)[:, None]) % 3
        corners = np.take_along_axis(corners, order[:, None], axis=0)
        middle = (corners[0] + corners[1]) / 2
        radii = np.sqrt(((corners - middle) ** 2).sum(axis=1).max(axis=0))
        large = radii > limit
        if finished + len(parent) + np.count_nonzero(large) > _MOST_PIECES:
            large[:] = False
        done.append((parent[~large], middle[:, ~large].T, radii[~large]))
        finished += int(np.count_nonzero(~large))
        if not large.any():
            parents, centers, sizes = (np.concatenate(parts) for parts in zip(*done, strict=True))
            return parents, centers, sizes
        (first, second, third), halves = corners[:, :, large], middle[:, large]
        corners = np.concatenate(
            [np.stack([first, halves, third]), np.stack([halves, second, third])], axis=2
        )
        parent = np.tile(parent[large], 2)
