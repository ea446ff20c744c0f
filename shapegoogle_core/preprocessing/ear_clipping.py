# SPDX-License-Identifier: MIT
"""Ear clipping: triangles for the polygon that a removed vertex leaves (Meisters 1975)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Triangle", "clip_ears", "outline_around"]

Triangle = tuple[int, int, int]


def outline_around(vertex: int, faces: Sequence[Sequence[int]]) -> list[int]:
    """Find the polygon that faces around a vertex cover.

    Parameters
    ----------
    vertex : int
    faces : sequence of (3,) sequences of int
        All faces around it, or all that lie in one plane.

    Returns
    -------
    outline : list of int
        Other corners of the faces, in the direction of the faces: a ring, or a chain from one edge of the
        vertex to another. Empty if they are several.
    """
    following: dict[int, int] = {}
    for face in faces:
        place = list(face).index(vertex)
        following[face[(place + 1) % 3]] = face[(place + 2) % 3]
    if len(following) < len(faces):
        return []
    starts = set(following) - set(following.values())
    first = min(starts or following)
    outline = [first]
    while outline[-1] in following:
        here = following.pop(outline[-1])
        if here == first:
            break
        outline.append(here)
    return [] if following else outline


def clip_ears(polygon: Sequence[int], points: FloatArray, tolerance: float) -> list[Triangle]:
    """Cut a simple polygon into triangles.

    Parameters
    ----------
    polygon : sequence of k int
        Its corners, counterclockwise.
    points : (k, 2) array
        Their positions.
    tolerance : float
        No triangle is lower.

    Returns
    -------
    triangles : list of k - 2 triples of int
        Empty if there are none high enough.
    """
    left = list(range(len(polygon)))
    triangles: list[Triangle] = []
    while len(left) > 3:
        best, ear = 0.0, -1
        for index in range(len(left)):
            corners = left[index - 1], left[index], left[(index + 1) % len(left)]
            height = _height(points[list(corners)])
            others = [corner for corner in left if corner not in corners]
            if height > max(best, tolerance) and not _any_inside(
                points[list(corners)], points[others], tolerance
            ):
                best, ear = height, index
        if ear < 0:
            return []
        before, after = left[ear - 1], left[(ear + 1) % len(left)]
        triangles.append((polygon[before], polygon[left[ear]], polygon[after]))
        del left[ear]
    if len(left) < 3 or _height(points[left]) <= tolerance:
        return []
    triangles.append((polygon[left[0]], polygon[left[1]], polygon[left[2]]))
    return triangles


def _height(corners: FloatArray) -> float:
    """Least height of a triangle, negative if it is clockwise."""
    first, second = corners[1] - corners[0], corners[2] - corners[1]
    longest = max(np.hypot(*first), np.hypot(*second), np.hypot(*(corners[2] - corners[0])))
    return float((first[0] * second[1] - first[1] * second[0]) / max(longest, np.finfo(float).tiny))


def _any_inside(corners: FloatArray, points: FloatArray, tolerance: float) -> bool:
    """Whether any point is inside a counterclockwise triangle or on its outline."""
    side = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(side[:, 0], side[:, 1])
    offset = points[:, None] - corners[None]
    height = (side[:, 0] * offset[:, :, 1] - side[:, 1] * offset[:, :, 0]) / length
    return bool((height > -tolerance).all(axis=1).any())
