# SPDX-License-Identifier: MIT
"""Parts of objects: boxes, turned and bent bodies, prisms and sheets, moved into place and joined."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from benchmarks.flat_parts.polygons import prism_faces, solid
from shapegoogle_core.mesh.mesh import FloatArray, IntArray

# Rows of numbers from here and there: lists, tuples and arrays.
Points = ArrayLike | Sequence[object]

__all__ = [
    "Part",
    "around",
    "ball",
    "box",
    "curve",
    "cylinder",
    "join",
    "lathe",
    "loft",
    "mirrored_pair",
    "prism",
    "ring",
    "sheet",
    "tube",
]


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one part. Up is z, and an object faces -y."""

    vertices: FloatArray
    faces: IntArray

    def at(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Part:
        """Move the part."""
        return Part(self.vertices + np.array([x, y, z]), self.faces)

    def turned(self, axis: str, degrees: float) -> Part:
        """Rotate the part about an axis ("x", "y" or "z") through the origin."""
        first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
        angle = np.radians(degrees)
        vertices = self.vertices.copy()
        a, b = self.vertices[:, first], self.vertices[:, second]
        vertices[:, first] = np.cos(angle) * a - np.sin(angle) * b
        vertices[:, second] = np.sin(angle) * a + np.cos(angle) * b
        return Part(vertices, self.faces)

    def scaled(self, x: float = 1.0, y: float = 1.0, z: float = 1.0) -> Part:
        """Stretch the part along the axes; a negative factor mirrors it."""
        turned = self.faces if x * y * z > 0 else self.faces[:, ::-1]
        return Part(self.vertices * np.array([x, y, z]), turned)


def join(parts: Iterable[Part]) -> Part:
    """Join parts without welding them, as modellers do."""
    listed = list(parts)
    offsets = np.cumsum([0, *(len(part.vertices) for part in listed[:-1])])
    faces = [part.faces + offset for part, offset in zip(listed, offsets, strict=True)]
    return Part(np.concatenate([part.vertices for part in listed]), np.concatenate(faces).astype(np.int32))


def around(part: Part, count: int, first: float = 0.0, sweep: float = 360.0) -> Part:
    """Repeat a part about the z axis."""
    return join(part.turned("z", first + sweep * number / count) for number in range(count))


def mirrored_pair(part: Part) -> Part:
    """Join a part and its mirror image at x = 0."""
    return join([part, part.scaled(x=-1)])


def curve(points: Points, count: int) -> FloatArray:
    """Interpolate points smoothly, without overshooting, in `count` steps."""
    knots = np.asarray(points, np.float64)
    lengths = np.linalg.norm(np.diff(knots, axis=0), axis=1)
    places = np.concatenate([[0.0], np.cumsum(lengths)])
    return np.asarray(PchipInterpolator(places, knots)(np.linspace(0, places[-1], count)))


def loft(loops: Points, caps: bool = True, closed: bool = False) -> Part:
    """Span a surface over loops of equally many points, (k, n, 3).

    The ends are closed by fans from their centroid (`caps`), or the last loop is joined to the first
    (`closed`).
    """
    points = np.asarray(loops, np.float64)
    count, size = points.shape[:2]
    first, second = np.meshgrid(np.arange(count if closed else count - 1), np.arange(size), indexing="ij")
    after, beside = (first + 1) % count, (second + 1) % size
    a, b, c, d = (
        row * size + column
        for row, column in ((first, second), (first, beside), (after, beside), (after, second))
    )
    faces = [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
    vertices = points.reshape(-1, 3)
    if caps and not closed:
        vertices = np.concatenate([vertices, points[0].mean(axis=0)[None], points[-1].mean(axis=0)[None]])
        here = np.arange(size)
        low, high = np.full(size, count * size), np.full(size, count * size + 1)
        faces.append(np.stack([low, (here + 1) % size, here], -1))
        last = (count - 1) * size
        faces.append(np.stack([high, last + here, last + (here + 1) % size], -1))
    return _without_slivers(Part(vertices, np.concatenate(faces).astype(np.int32)))


def _without_slivers(part: Part) -> Part:
    a, b, c = (part.vertices[part.faces[:, corner]] for corner in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return Part(part.vertices, part.faces[areas > 1e-12 * max(areas.max(), 1e-300)])


def box(width: float, depth: float, height: float, top: float | tuple[float, float] = 1.0) -> Part:
    """Make a box that stands on z = 0; `top` scales its upper side, in x and y."""
    scale = np.broadcast_to(np.asarray(top, np.float64), 2)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array([width, depth]) / 2
    loops = [np.column_stack([corners * factor, np.full(4, z)]) for factor, z in ((1, 0), (scale, height))]
    return loft(loops)


def lathe(profile: Points, sides: int, closed: bool = False) -> Part:
    """Turn a profile of (radius, z) about the z axis."""
    rows = np.asarray(profile, np.float64)
    angle = 2 * np.pi * np.arange(sides) / sides
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    loops = [np.column_stack([radius * circle, np.full(sides, z)]) for radius, z in rows]
    return loft(loops, caps=False, closed=closed)


def cylinder(radius: float, height: float, sides: int = 16, top: float | None = None) -> Part:
    """Make a cylinder or a truncated cone that stands on z = 0."""
    upper = radius if top is None else top
    return lathe([(0, 0), (radius, 0), (upper, height), (0, height)], sides)


def ball(x: float, y: float, z: float, sides: int = 16) -> Part:
    """Make an ellipsoid with these radii, its centre at the origin."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, max(4, sides // 2 + 1))
    return lathe(np.stack([np.cos(angle), np.sin(angle)], axis=1), sides).scaled(x, y, z)


def ring(radius: float, thickness: float, sides: int = 24, around_tube: int = 8) -> Part:
    """Make a torus about the z axis."""
    angle = 2 * np.pi * np.arange(around_tube) / around_tube
    return lathe(
        np.stack([radius + thickness * np.cos(angle), thickness * np.sin(angle)], axis=1), sides, closed=True
    )


def tube(points: Points, radii: float | Sequence[float] | FloatArray, sides: int = 8) -> Part:
    """Make a round bar along a path, with one radius or one for each point."""
    path = np.asarray(points, np.float64)
    thickness = np.broadcast_to(np.asarray(radii, np.float64), len(path))
    steps = np.gradient(path, axis=0)
    steps /= np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-12)
    side = np.cross(steps[0], np.eye(3)[int(np.abs(steps[0]).argmin())])
    angle = 2 * np.pi * np.arange(sides) / sides
    loops = []
    for place, step, radius in zip(path, steps, thickness, strict=True):
        side = side - (side @ step) * step  # carried along, so that the bar does not twist
        side /= max(float(np.linalg.norm(side)), 1e-12)
        other = np.cross(step, side)
        loops.append(place + radius * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * other))
    return loft(loops)


def prism(outline: Points, height: float, holes: Sequence[FloatArray] = ()) -> Part:
    """Raise a polygon of (x, y), which need not be convex and may have holes, from z = 0."""
    mesh = solid(prism_faces(np.asarray(outline, np.float64), holes, 0.0, height), "prism")
    return Part(np.array(mesh.vertices), np.array(mesh.faces))


def sheet(grid: Points) -> Part:
    """Make an open surface over a grid of points, (k, n, 3)."""
    points = np.asarray(grid, np.float64)
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return _without_slivers(Part(points.reshape(-1, 3), faces.astype(np.int32)))
