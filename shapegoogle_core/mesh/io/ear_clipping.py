# SPDX-License-Identifier: MIT
"""Cutting polygons that are not convex into triangles."""

from __future__ import annotations

from itertools import pairwise

import mapbox_earcut
import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["clip_ears", "newell_normals"]

# Corners are on a line if they are not further from it than this share of its length.
_ON_LINE = 1e-9


def newell_normals(points: FloatArray) -> FloatArray:
    """Compute twice the area vectors of polygons (Newell's method).

    Parameters
    ----------
    points : (..., n, 3) array
        Corners in order.

    Returns
    -------
    normals : (..., 3) array
        They also fit corners that are not quite in one plane.
    """
    spokes = points - points[..., :1, :]
    normals: FloatArray = np.cross(spokes[..., 1:-1, :], spokes[..., 2:, :]).sum(axis=-2)
    return normals


def clip_ears(points: FloatArray, rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Cut polygons into triangles that cover the same surface and have the same sides.

    A hole may be joined with the outline by a bridge: two sides along one line, there and back.

    Parameters
    ----------
    points : (v, 3) array
    rows : (k, n) array of int
        Corners of polygons of one size, in order; a polygon may use a point several times.

    Returns
    -------
    triangles : list of (m, 3) array of int
        For each polygon, with its orientation. m is n - 2, less if corners coincide or the outline runs to a
        corner and back.
    """
    in_order, corners = np.sort(rows, axis=1), points[rows]
    repeats = (in_order[:, 1:] == in_order[:, :-1]).any(axis=1)
    repeats |= (corners == np.roll(corners, 1, axis=1)).all(axis=2).any(axis=1)
    flat, all_places = _projected(corners), np.arange(rows.shape[1])
    cut = []
    for place, row in enumerate(rows):
        ring = _without_spikes(corners[place]) if repeats[place] else all_places
        triangles = _clip(flat[place], ring)
        if len(triangles) < len(ring) - 2 and _bends_where_cut_off(corners[place], ring, triangles):
            triangles = _fan(ring)
        cut.append(row[triangles])
    return cut


def _projected(corners: FloatArray) -> FloatArray:
    """Project polygons, (k, n, 3), along the largest axis of their normals, to have a positive area.

    Along an axis the coordinates stay as they are, so that what is on a line stays on it.
    """
    normals = newell_normals(corners)
    every = np.arange(len(corners))
    axis = np.abs(normals).argmax(axis=1)
    upright = normals[every, axis] > 0
    first, second = np.where(upright, axis + 1, axis + 2) % 3, np.where(upright, axis + 2, axis + 1) % 3
    local = corners - corners[:, :1]
    return np.stack([local[every, :, first], local[every, :, second]], axis=2)


def _bends_where_cut_off(corners: FloatArray, ring: NDArray[np.int64], triangles: NDArray[np.int64]) -> bool:
    """Tell whether a corner without a triangle is off the line of its neighbours, though not as projected.

    A side of a strongly bent outline may run back along another one, seen along the normal.
    """
    before, after = corners[np.roll(ring, 1)], corners[np.roll(ring, -1)]
    to_before, to_after = before - corners[ring], after - corners[ring]
    off = np.linalg.norm(np.cross(to_before, to_after), axis=1)
    length = np.maximum(np.linalg.norm(to_before, axis=1), np.linalg.norm(to_after, axis=1))
    return bool((off > 1e-6 * length**2)[~np.isin(ring, triangles)].any())


def _fan(ring: NDArray[np.int64]) -> NDArray[np.int64]:
    return ring[[[0, corner, corner + 1] for corner in range(1, len(ring) - 1)]]


def _clip(flat: FloatArray, ring: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut one polygon, given by its corners in the plane and the places of those that count."""
    if len(ring) < 3:
        return np.empty((0, 3), np.int64)
    flat = flat[ring]
    found = mapbox_earcut.triangulate_float64(flat, np.array([len(ring)], np.uint32))
    triangles = found.astype(np.int64).reshape(-1, 3)
    if len(triangles) and _turns_right(flat, triangles):
        triangles = triangles[:, ::-1]
    if len(triangles) < len(ring) - 2:
        triangles = _with_corners_on_sides(flat, triangles)
    return ring[triangles] if len(triangles) else _fan(ring)  # without any area


def _without_spikes(corners: FloatArray) -> NDArray[np.int64]:
    """Return the places of the corners without coinciding ones, and without those where a side runs back."""
    kept: list[int] = []
    names = np.unique(corners, axis=0, return_inverse=True)[1].ravel().tolist()
    for place, name in enumerate(names):
        kept.append(place)
        while len(kept) > 1 and (names[kept[-2]] == name or (len(kept) > 2 and names[kept[-3]] == name)):
            del kept[-1 if names[kept[-2]] == name else -2 :]
            name = names[kept[-1]]
    while len(kept) > 2:
        if names[kept[0]] == names[kept[-1]]:
            kept.pop()
        elif names[kept[0]] == names[kept[-2]]:
            del kept[-2:]
        elif names[kept[1]] == names[kept[-1]]:
            del kept[0], kept[-1]
        else:
            break
    return np.array(kept, np.int64)


def _turns_right(flat: FloatArray, triangles: NDArray[np.int64]) -> bool:
    """Tell whether triangles have a negative area together."""
    a, b, c = flat[triangles].transpose(1, 2, 0)
    areas: FloatArray = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return bool(areas.sum() < 0)


def _with_corners_on_sides(flat: FloatArray, triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Add corners that lie on a side of a triangle, where the library has left them out.

    It drops corners on a line with their neighbours. Without them the sides of a polygon would not meet those
    of the next one.
    """
    count = len(flat)
    apexes = {
        (triangle[side], triangle[(side + 1) % 3]): triangle[(side + 2) % 3]
        for triangle in triangles.tolist()
        for side in range(3)
    }
    for first, last in _open_sides(apexes, count):
        skipped = [(first + step) % count for step in range((last - first) % count + 1)]
        if _is_straight(flat[skipped]):
            _divide(apexes, skipped)
    # A side may also run over corners that other triangles have.
    sides = _open_sides(apexes, count)
    ends = sorted({corner for side in sides for corner in side})
    closed = apexes.copy()
    for first, last in sides:
        _divide(closed, [first, *_on_side(flat, first, last, ends), last])
    if not _open_sides(closed, count) and len(closed) == 3 * (count - 2):
        return _triangles(closed)
    return _triangles(apexes) if len(apexes) <= 3 * (count - 2) else triangles


def _triangles(apexes: dict[tuple[int, int], int]) -> NDArray[np.int64]:
    return np.array([[a, b, c] for (a, b), c in apexes.items() if a < min(b, c)], np.int64).reshape(-1, 3)


def _open_sides(apexes: dict[tuple[int, int], int], count: int) -> list[tuple[int, int]]:
    """List the sides that neither meet another triangle nor are sides of the polygon."""
    return [side for side in apexes if side[::-1] not in apexes and side[1] != (side[0] + 1) % count]


def _divide(apexes: dict[tuple[int, int], int], corners: list[int]) -> None:
    """Divide the triangle on the side from the first to the last of some corners at those between."""
    apex = apexes.pop((corners[0], corners[-1]))
    for start, end in pairwise(corners):
        apexes |= {(start, end): apex, (end, apex): start, (apex, start): end}


def _is_straight(points: FloatArray) -> bool:
    """Tell whether points lie in their order on the line from the first to the last."""
    shares, is_near = _along(points, points[0], points[-1])
    return bool((np.diff(shares) >= 0).all() and is_near.all())


def _on_side(flat: FloatArray, first: int, last: int, corners: list[int]) -> list[int]:
    """Return the corners between the ends of a side, in their order."""
    shares, is_near = _along(flat[corners], flat[first], flat[last])
    places = np.flatnonzero(is_near & (shares > 0) & (shares < 1))
    return [corners[place] for place in places[np.argsort(shares[places], kind="stable")]]


def _along(points: FloatArray, start: FloatArray, end: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return where points lie along a side, 0 to 1 from start to end, and whether they are on its line."""
    along, away = end - start, points - start
    square = max(float(along @ along), np.finfo(np.float64).tiny)
    shares: FloatArray = away @ along / square
    return shares, np.abs(away @ np.array([-along[1], along[0]])) <= _ON_LINE * square
