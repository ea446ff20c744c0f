# SPDX-License-Identifier: MIT
"""Cutting one polygon that is not convex into triangles."""

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


def clip_ears(points: FloatArray, corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cut a polygon into triangles that cover the same surface and have the same sides.

    A hole may be joined with the outline by a bridge: two sides along one line, there and back.

    Parameters
    ----------
    points : (n, 3) array
        Corners in order.
    corners : (n,) array of int
        Their vertices; the same one may come several times.

    Returns
    -------
    triangles : (m, 3) array of int
        Places in `corners`, with the orientation of the polygon. m is n - 2, less if the outline runs to a
        corner and back.
    """
    ring = _without_spikes(corners)
    if len(ring) < 3:
        return np.empty((0, 3), np.int64)
    normal = newell_normals(points[ring])
    # Along the largest axis the outline projects without rounding.
    axis = int(np.abs(normal).argmax())
    plane = [(axis + 1) % 3, (axis + 2) % 3] if normal[axis] > 0 else [(axis + 2) % 3, (axis + 1) % 3]
    flat = np.ascontiguousarray(points[ring][:, plane] - points[ring[0], plane])
    found = mapbox_earcut.triangulate_float64(flat, np.array([len(ring)], np.uint32))
    triangles = found.astype(np.int64).reshape(-1, 3)
    if _signed_areas(flat, triangles).sum() < 0:
        triangles = triangles[:, ::-1]
    if len(triangles) < len(ring) - 2:
        triangles = _with_corners_on_sides(flat, triangles)
    if not len(triangles):  # no area at all
        triangles = np.array([[0, corner, corner + 1] for corner in range(1, len(ring) - 1)])
    return ring[triangles]


def _without_spikes(corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the places of the corners without repeated ones, and without those where a side runs back."""
    kept: list[int] = []
    names = corners.tolist()
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


def _signed_areas(flat: FloatArray, triangles: NDArray[np.int64]) -> FloatArray:
    a, b, c = flat[triangles].transpose(1, 2, 0)
    areas: FloatArray = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return areas


def _with_corners_on_sides(flat: FloatArray, triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Add the corners that the library drops because they lie on a line with their neighbours.

    Without them the sides of a polygon would not meet those of the next one.
    """
    apexes = {
        (triangle[side], triangle[(side + 1) % 3]): triangle[(side + 2) % 3]
        for triangle in triangles.tolist()
        for side in range(3)
    }
    count = len(flat)
    for first, last in [side for side in apexes if side[::-1] not in apexes]:
        skipped = [(first + step) % count for step in range((last - first) % count + 1)]
        if len(skipped) < 3 or not _is_straight(flat[skipped]):
            continue
        apex = apexes.pop((first, last))
        for start, end in pairwise(skipped):
            apexes |= {(start, end): apex, (end, apex): start, (apex, start): end}
    return np.array([[a, b, c] for (a, b), c in apexes.items() if a < min(b, c)], np.int64).reshape(-1, 3)


def _is_straight(points: FloatArray) -> bool:
    """Tell whether points lie in their order on the line from the first to the last."""
    along = points[-1] - points[0]
    square = float(along @ along)
    steps = (points - points[0]) @ along
    off = (points - points[0]) @ np.array([-along[1], along[0]])
    return bool((np.diff(steps) >= 0).all() and (np.abs(off) <= _ON_LINE * square).all())
