# SPDX-License-Identifier: MIT
"""Solids from planar polygons with holes, triangulated with as few triangles as CAD exporters use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Face", "circle", "prism_faces", "rectangle", "solid"]


@dataclass(frozen=True, eq=False)
class Face:
    """A planar polygon with holes.

    Attributes
    ----------
    outline : (n, 3) array
    holes : sequence of (k, 3) array
    """

    outline: FloatArray
    holes: Sequence[FloatArray] = ()


def circle(x: float, y: float, radius: float, sides: int = 24) -> FloatArray:
    """Make a regular polygon.

    Parameters
    ----------
    x, y, radius : float
    sides : int, optional

    Returns
    -------
    corners : (sides, 2) array
        Anticlockwise.
    """
    angle = 2 * np.pi * np.arange(sides) / sides
    return np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=1)


def rectangle(width: float, depth: float, x: float = 0.0, y: float = 0.0) -> FloatArray:
    """Make a rectangle with its lowest corner at (x, y), as a (4, 2) array."""
    return np.array([[x, y], [x + width, y], [x + width, y + depth], [x, y + depth]], np.float64)


def prism_faces(
    outline: FloatArray, holes: Sequence[FloatArray], low: float, high: float, *, ends: str = "both"
) -> list[Face]:
    """List the faces of a polygon moved along z.

    Parameters
    ----------
    outline : (n, 2) array
    holes : sequence of (k, 2) array
    low, high : float
    ends : {"both", "low", "none"}, optional
        Which ends are closed.

    Returns
    -------
    faces : list of Face
    """
    faces = []
    for loop in (outline, *holes):
        for start, end in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            corners = [(*start, low), (*end, low), (*end, high), (*start, high)]
            faces.append(Face(np.array(corners)))
    heights = {"both": (low, high), "low": (low,), "none": ()}[ends]
    faces += [Face(_lifted(outline, z), [_lifted(hole, z) for hole in holes]) for z in heights]
    return faces


def solid(faces: Sequence[Face], name: str) -> Mesh:
    """Triangulate faces and weld them.

    Parameters
    ----------
    faces : sequence of Face
        Of a closed surface; their orientation does not matter.
    name : str

    Returns
    -------
    mesh : Mesh
        Consistently oriented, outwards.
    """
    import trimesh

    corners = np.concatenate([_triangles(face) for face in faces])
    joined = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    joined.merge_vertices(digits_vertex=9)
    trimesh.repair.fix_normals(joined)  # type: ignore[no-untyped-call]
    return Mesh(np.asarray(joined.vertices), np.asarray(joined.faces), name)


def _lifted(loop: FloatArray, z: float) -> FloatArray:
    return np.column_stack([loop, np.full(len(loop), z)])


def _triangles(face: Face) -> FloatArray:
    """Triangulate a face by bridges to its holes and ear clipping, (m, 3, 3)."""
    points = np.concatenate([face.outline, *face.holes])
    centered = points - points.mean(axis=0)
    axes = np.linalg.svd(centered, full_matrices=False)[2][:2]
    flat = centered @ axes.T
    loops, start = [], 0
    for loop in (face.outline, *face.holes):
        indices = list(range(start, start + len(loop)))
        # The outline anticlockwise, the holes clockwise.
        if (_signed_area(flat[indices]) > 0) != (start == 0):
            indices.reverse()
        loops.append(indices)
        start += len(loop)
    outline = loops[0]
    for hole in sorted(loops[1:], key=lambda indices: -float(flat[indices, 0].max())):
        outline = _bridged(flat, outline, hole)
    return np.asarray(points[np.array(_ears(flat, outline))])


def _signed_area(loop: FloatArray) -> float:
    following = np.roll(loop, -1, axis=0)
    return float((loop[:, 0] * following[:, 1] - loop[:, 1] * following[:, 0]).sum() / 2)


def _cross(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    return np.asarray(
        (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])
    )


def _bridged(flat: FloatArray, outline: list[int], hole: list[int]) -> list[int]:
    """Join a hole to the outline at its rightmost corner, by the shortest bridge that crosses nothing."""
    tip = max(range(len(hole)), key=lambda place: flat[hole[place], 0])
    turned = hole[tip:] + hole[:tip]
    here = flat[turned[0]]
    ends = flat[outline]
    first, second = flat[outline], flat[np.roll(outline, -1)]
    for place in np.argsort(np.linalg.norm(ends - here, axis=1), kind="stable").tolist():
        there = flat[outline[place]]
        if there[0] < here[0]:
            continue
        # Strict crossings with sides that do not end at the bridge's end.
        apart = (np.abs(first - there).max(axis=1) > 0) & (np.abs(second - there).max(axis=1) > 0)
        crossed = (_cross(first, second, here[None]) * _cross(first, second, there[None]) <= 0) & (
            _cross(here[None], there[None], first) * _cross(here[None], there[None], second) <= 0
        )
        inside = _sees(flat, outline, place, here)
        if inside and not (crossed & apart).any():
            return [*outline[: place + 1], *turned, turned[0], *outline[place:]]
    raise ValueError("a hole has no bridge to the outline")


def _sees(flat: FloatArray, outline: list[int], place: int, target: FloatArray) -> bool:
    """Whether a target lies inside the angle at a corner of the outline."""
    before, here, after = (flat[outline[(place + step) % len(outline)]] for step in (-1, 0, 1))
    left_of_in, left_of_out = _cross(before, here, target) > 0, _cross(here, after, target) > 0
    convex = _cross(before, here, after) > 0
    return bool(left_of_in and left_of_out) if convex else bool(left_of_in or left_of_out)


def _ears(flat: FloatArray, outline: list[int]) -> list[tuple[int, int, int]]:
    left, triangles = list(outline), []
    while len(left) > 3:
        for place in range(len(left)):
            a, b, c = left[place - 1], left[place], left[(place + 1) % len(left)]
            if _cross(flat[a], flat[b], flat[c]) <= 1e-12:
                continue
            others = flat[[index for index in left if index not in (a, b, c)]]
            corners = flat[a], flat[b], flat[c]
            inside = np.ones(len(others), bool)
            for start, end in zip(corners, (*corners[1:], corners[0]), strict=True):
                inside &= _cross(start, end, others) >= -1e-12
            if not inside.any():
                triangles.append((a, b, c))
                del left[place]
                break
        else:
            raise ValueError("a polygon has no ear")
    return [*triangles, (left[0], left[1], left[2])]
