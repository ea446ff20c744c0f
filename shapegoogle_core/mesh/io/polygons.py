# SPDX-License-Identifier: MIT
"""The output of every reader: vertices and polygons; and the one place where polygons become triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.ear_clipping import clip_ears, newell_normals
from shapegoogle_core.mesh.io.file import DamagedError, FormatError, check_face_count
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Polygons", "triangulate", "without_lost_points"]

# A triangle with less than this share of its quad's area is avoided if the other diagonal gives two larger.
_LEAST_SHARE = 1e-9

_AT_ONCE = 8192

# Largest share of faces that are left out because their points have no finite coordinates.
_MOST_LEFT_OUT = 0.1


@dataclass(frozen=True)
class Polygons:
    """Vertices and faces as they are in a file.

    Parameters
    ----------
    vertices : (n, 3) array of float64
    corners : (c,) array of int
        Vertices of all polygons, one polygon after the other, counted from 0.
    sizes : (p,) array of int
        Number of corners of each polygon; their sum is c. Empty for points alone.
    notes : tuple of str
        What of the file was not read. Each completes the sentence "<file> …".
    """

    vertices: FloatArray
    corners: NDArray[np.int64]
    sizes: NDArray[np.int64]
    notes: tuple[str, ...] = ()

    @classmethod
    def from_triangles(cls, vertices: FloatArray, faces: NDArray[np.int64]) -> Polygons:
        """Take triangles, an (m, 3) array."""
        return cls(vertices, faces.ravel(), np.full(len(faces), 3))

    @classmethod
    def from_points(cls, vertices: FloatArray, notes: tuple[str, ...] = ()) -> Polygons:
        """Take points without faces."""
        return cls(vertices, np.empty(0, np.int64), np.empty(0, np.int64), notes)


def without_lost_points(polygons: Polygons) -> Polygons:
    """Leave out points whose coordinates are not finite, and polygons that use them.

    Scanners write such points for rays that met nothing; a few of them may be damage. With many faces
    missing it would be another shape.

    Parameters
    ----------
    polygons : Polygons

    Returns
    -------
    polygons : Polygons
        The same if all coordinates are finite; else with a note that counts what was left out.

    Raises
    ------
    FormatError
        If many faces use such points, or a polygon names a vertex that is not there.
    """
    vertices, corners, sizes = polygons.vertices, polygons.corners, polygons.sizes
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(vertices.sum()):
            return polygons
    sound = np.atleast_1d(np.isfinite(vertices).all(axis=1))
    if sound.all():
        return polygons
    if not sound.any():
        raise FormatError(
            f"has no finite coordinates: those of all {len(vertices):,} points are NaN or infinite; "
            "export it again"
        )
    lost = len(vertices) - int(sound.sum())
    _check_corners(polygons)
    # Points and lines of a file may name any vertex: they are no surface.
    uses_lost = ~sound[np.clip(corners, 0, len(vertices) - 1)]
    complete = np.ones(len(sizes), bool)
    complete[np.repeat(np.arange(len(sizes)), sizes)[uses_lost]] = False
    left_out = int((~complete & (sizes > 2)).sum())
    faces = f", and {left_out:,} of {len(sizes):,} faces use them" if left_out else ""
    note = f"has {lost:,} of {len(vertices):,} points without finite coordinates (NaN or infinite){faces}"
    if left_out > _MOST_LEFT_OUT * len(sizes):
        raise FormatError(f"{note}; repair it or export it again")
    places = np.cumsum(sound) - 1
    return Polygons(
        vertices[sound],
        places[np.clip(corners, 0, len(vertices) - 1)][np.repeat(complete, sizes)],
        sizes[complete],
        (*polygons.notes, f"{note}; they were left out"),
    )


def triangulate(polygons: Polygons, max_faces: int) -> NDArray[np.int64]:
    """Cut polygons into triangles that cover the same surface.

    A quad is cut along the diagonal that starts at its first corner, unless it is concave and only the
    other one lies inside. A larger polygon becomes the fan of its first corner if this covers it exactly,
    as it does in a convex one; otherwise ears are clipped from it. The sides of polygons stay as they are,
    and triangles have the orientation of their polygon: the direction of its area vector.

    Parameters
    ----------
    polygons : Polygons
        Polygons of fewer than three corners are points and lines, and give nothing.
    max_faces : int
        Largest number of triangles.

    Returns
    -------
    triangles : (m, 3) array of int
        In the order of the polygons. If all of them are quads, the first triangles of all come before the
        second ones: simplification depends on the order, and the shipped models were made with this one.

    Raises
    ------
    FormatError
        If there are more triangles than `max_faces`, or a polygon names a vertex that is not there.
    """
    corners, sizes = polygons.corners, polygons.sizes
    counts = np.maximum(sizes - 2, 0)
    check_face_count(int(counts.sum()), max_faces)
    _check_corners(polygons)
    if len(sizes) and (sizes == sizes[0]).all() and sizes[0] in (3, 4):
        rows = corners.reshape(len(sizes), -1)
        return rows if sizes[0] == 3 else np.concatenate(_halves(_usual_scale(polygons.vertices), rows))
    starts, places = np.cumsum(sizes) - sizes, np.cumsum(counts) - counts
    triangles = np.empty((int(counts.sum()), 3), np.int64)
    left_out = np.zeros(len(triangles), bool)
    points = _usual_scale(polygons.vertices) if (sizes > 3).any() else polygons.vertices
    for size in np.unique(sizes[sizes > 2]).tolist():
        chosen = np.flatnonzero(sizes == size)
        rows = corners[starts[chosen, None] + np.arange(size)]
        if size == 4:
            cut = np.stack(_halves(points, rows), axis=1)
        else:
            cut = rows[:, [[0, corner, corner + 1] for corner in range(1, size - 1)]]
        triangles[places[chosen, None] + np.arange(size - 2)] = cut
        if size < 5:
            continue
        others = np.flatnonzero(~_fan_covers(points, rows))
        for place, clipped in zip(places[chosen[others]], clip_ears(points, rows[others]), strict=True):
            triangles[place : place + len(clipped)] = clipped
            left_out[place + len(clipped) : place + size - 2] = True  # spikes have no surface
    return triangles[~left_out] if left_out.any() else triangles


def _check_corners(polygons: Polygons) -> None:
    corners, sizes, count = polygons.corners, polygons.sizes, len(polygons.vertices)
    if not corners.size or (corners.min() >= 0 and corners.max() < count):
        return
    wrong = np.flatnonzero(((corners < 0) | (corners >= count)) & np.repeat(sizes > 2, sizes))
    if len(wrong):
        face = int(np.searchsorted(np.cumsum(sizes), wrong[0], "right"))
        raise DamagedError(
            f"names vertex {corners[wrong[0]]} in face {face:,}, but counted from 0 there are only vertices "
            f"0 to {count - 1:,}"
        )


def _usual_scale(vertices: FloatArray) -> FloatArray:
    """Scale by a power of two, which changes no digit, where products of four lengths would overflow."""
    if not len(vertices):
        return vertices
    _, exponent = np.frexp(max(vertices.max(), -vertices.min()))
    return vertices if abs(exponent) < 200 else np.ldexp(vertices, -exponent)


def _halves(points: FloatArray, rows: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Cut quads, (k, 4), from corner 0 to 2, or from 1 to 3 where only this diagonal is inside."""
    first, second = rows[:, [0, 1, 2]], rows[:, [2, 3, 0]]
    smaller, whole = _smaller_half(points, rows)
    doubtful = np.flatnonzero(~(smaller > _LEAST_SHARE * whole))
    if len(doubtful):
        other, _ = _smaller_half(points, np.roll(rows[doubtful], -1, axis=1))
        turned = doubtful[other > np.maximum(smaller[doubtful], _LEAST_SHARE * whole[doubtful])]
        first[turned], second[turned] = rows[turned][:, [0, 1, 3]], rows[turned][:, [1, 2, 3]]
    return first, second


def _smaller_half(points: FloatArray, rows: NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
    """Cut quads from corner 0 to 2: the smaller area and that of both, each along the area vector."""
    smaller, whole = np.empty((2, len(rows)))
    axes, corners = np.ascontiguousarray(points.T), np.ascontiguousarray(rows.T)
    # Axis by axis and in pieces that fit into the processor's cache: several times as fast as np.cross.
    for start in range(0, len(rows), _AT_ONCE):
        piece = slice(start, start + _AT_ONCE)
        quads = (axis[corners[:, piece]] for axis in axes)
        (ax, bx, cx), (ay, by, cy), (az, bz, cz) = (quad[1:] - quad[0] for quad in quads)
        half = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        other = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        x, y, z = (one + two for one, two in zip(half, other, strict=True))
        part = half[0] * x + half[1] * y + half[2] * z
        rest = other[0] * x + other[1] * y + other[2] * z
        smaller[piece], whole[piece] = np.minimum(part, rest), part + rest
    return smaller, whole


def _fan_covers(points: FloatArray, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Tell for polygons of one size, (k, n), whether the fan of the first corner covers each exactly.

    It does if the directions to the other corners turn one way only, by less than half a turn.
    """
    spokes = points[rows[:, 1:]] - points[rows[:, :1]]
    turns = np.cross(spokes[:, :-1], spokes[:, 1:])
    normals = newell_normals(points[rows])
    share = _LEAST_SHARE * np.einsum("ij,ij->i", normals, normals)[:, None]
    one_way = np.einsum("ijk,ik->ij", turns, normals) > share
    from_first = np.einsum("ijk,ik->ij", np.cross(spokes[:, :1], spokes[:, 1:]), normals) > share
    covers: NDArray[np.bool_] = (one_way & from_first).all(axis=1)
    return covers
