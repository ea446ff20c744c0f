# SPDX-License-Identifier: MIT
"""Parts that procedural things are built from: boxes, rods, turned and extruded forms, tubes, lumps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from benchmarks.flat_parts.polygons import prism_faces, solid

__all__ = [
    "Maker",
    "Part",
    "Parts",
    "Random",
    "around",
    "ball",
    "box",
    "extruded",
    "lump",
    "moved",
    "rod",
    "tube",
    "turned",
    "turned_about",
]

Random: TypeAlias = np.random.Generator
Part: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Vertices and faces."""
Parts: TypeAlias = list[Part]
Points: TypeAlias = ArrayLike | Sequence[Any]
Maker: TypeAlias = Callable[[Random], Parts]
"""Makes a member of a kind."""


def _part(mesh: trimesh.Trimesh) -> Part:
    return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)


def moved(part: Part, shift: ArrayLike = (0, 0, 0), scale: ArrayLike = 1) -> Part:
    """Scale a part about the origin, then move it."""
    return part[0] * np.asarray(scale, float) + np.asarray(shift, float), part[1]


def turned_about(part: Part, axis: int, degrees: float) -> Part:
    """Turn a part about an axis (0, 1 or 2) through the origin."""
    angle = np.radians(degrees)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[first, first] = turn[second, second] = np.cos(angle)
    turn[first, second], turn[second, first] = -np.sin(angle), np.sin(angle)
    return part[0] @ turn.T, part[1]


def around(part: Part, count: int, start: float = 0) -> Parts:
    """Repeat a part evenly about the z axis."""
    return [turned_about(part, 2, start + 360 * number / count) for number in range(count)]


def box(size: Sequence[float] | NDArray[np.float64], at: Sequence[float] = (0, 0, 0)) -> Part:
    """Make a box; `at` is the middle of its bottom."""
    return moved(_part(trimesh.creation.box(np.asarray(size))), np.add(at, (0, 0, size[2] / 2)))


def ball(radius: float, at: ArrayLike = (0, 0, 0), stretch: ArrayLike = 1, detail: int = 2) -> Part:
    """Make a ball or an ellipsoid around a point."""
    return moved(_part(trimesh.creation.icosphere(detail)), at, radius * np.asarray(stretch, float))


def turned(profile: Points, sides: int = 20, at: ArrayLike = (0, 0, 0)) -> Part:
    """Turn a profile of points (radius, z) about the z axis; closed if it begins and ends on the axis."""
    points = np.asarray(profile, float)
    mesh = trimesh.creation.revolve(points, sections=sides)
    if mesh.volume < 0:  # the profile runs downwards on its outside
        mesh.invert()
    return moved(_part(mesh), at)


def rod(start: ArrayLike, end: ArrayLike, radius: float, tip: float | None = None, sides: int = 12) -> Part:
    """Make a round rod between two points; with the radius `tip` at its end."""
    start, end = np.asarray(start, float), np.asarray(end, float)
    length = float(np.linalg.norm(end - start))
    tip = radius if tip is None else tip
    profile = [[0, 0], [radius, 0], [tip, length]] + ([[0, length]] if tip else [])
    align, _ = Rotation.align_vectors([(end - start) / length], [[0, 0, 1]])
    vertices, faces = turned(profile, sides)
    return align.apply(vertices) + start, faces


def extruded(outline: Points, thickness: float) -> Part:
    """Extrude an outline in the xz plane, counter-clockwise seen from the front, along y."""
    mesh = solid(prism_faces(np.asarray(outline, float), [], -thickness / 2, thickness / 2), "part")
    x, y, z = mesh.vertices.T
    return np.stack([x, -z, y], axis=1), mesh.faces.astype(np.int64)


def tube(path: ArrayLike, radius: float | ArrayLike, sides: int = 8) -> Part:
    """Sweep a circle, whose radius may vary, along a path of points."""
    path = np.asarray(path, float)
    radii = np.broadcast_to(np.asarray(radius, float), len(path))
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along[0], [0.31, 0.87, 0.39])
    rings = []
    for point, way, size in zip(path, along, radii, strict=True):
        side = side - way * (side @ way)
        side /= np.linalg.norm(side)
        angles = 2 * np.pi * np.arange(sides) / sides
        rings.append(
            point + size * (np.cos(angles)[:, None] * side + np.sin(angles)[:, None] * np.cross(way, side))
        )
    vertices = np.concatenate([*rings, path[:1], path[-1:]])
    around_ring = np.arange(sides)
    beside = (around_ring + 1) % sides
    faces = []
    for number in range(len(path) - 1):
        low, high = number * sides, (number + 1) * sides
        faces.append(np.stack([low + around_ring, low + beside, high + around_ring], axis=1))
        faces.append(np.stack([high + around_ring, low + beside, high + beside], axis=1))
    first, last, end = len(vertices) - 2, len(vertices) - 1, (len(path) - 1) * sides
    faces.append(np.stack([beside, around_ring, np.full(sides, first)], axis=1))
    faces.append(np.stack([end + around_ring, end + beside, np.full(sides, last)], axis=1))
    return vertices, np.concatenate(faces)


def lump(random: Random, rough: float, detail: int = 3, waves: int = 12, sharp: float = 0) -> Part:
    """Make a lump: a ball with random waves on it, cut flat at random where `sharp` is above 0."""
    vertices, faces = ball(1, detail=detail)
    factor = np.ones(len(vertices))
    for _ in range(waves):
        way = random.normal(size=3) * random.uniform(0.5, 2.5)
        factor += rough / np.sqrt(waves) * np.sin(vertices @ way + random.uniform(0, 2 * np.pi))
    vertices = vertices * factor[:, None]
    for _ in range(int(sharp)):
        way = random.normal(size=3)
        way /= np.linalg.norm(way)
        beyond = np.maximum(vertices @ way - random.uniform(0.55, 0.85), 0)
        vertices -= beyond[:, None] * way
    return vertices * random.uniform(0.6, 1.4, 3), faces
