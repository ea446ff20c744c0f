# SPDX-License-Identifier: MIT
"""Polygons of every form become triangles with the same area, sides and orientation."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapegoogle_core.mesh.io.polygons import Polygons, triangulate
from shapegoogle_core.mesh.mesh import FloatArray
from tests.core.mesh.io.mesh_files import refuse, write

SHAPES: dict[str, list[tuple[float, float]]] = {
    "C": [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (3, 2), (3, 3), (0, 3)],
    "L": [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)],
    "U": [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)],
    "dart": [(0, 0), (2, 1), (4, 0), (2, 4)],
    "slit": [(0, 0), (2, 0), (2, 2), (1, 1e-5), (0, 2)],
    # A diagonal between two of its corners runs over a third one.
    "dents": [
        (8, 8),
        (4, 6),
        (5.125, 6),
        (5.875, 6),
        (7, 6),
        (7.75, 6),
        (8, 6),
        (7, 5),
        (8, 5),
        (8.375, 4.375),
        (9.875, 1.875),
        (11, 0),
        (10, 0.5),
        (8.5, 1.25),
        (7, 2),
        (5.5, 1.25),
        (4, 0.5),
        (3, 0),
        (3, 0.5),
        (3, 0.5),
        (3, 4),
        (2.625, 3.25),
        (2.25, 2.5),
        (2, 2),
        (0, 8),
        (0.5, 7.25),
        (0.5, 7.25),
        (2, 5),
        (1, 8),
    ],
    "triangle with corners on its sides": [(0, 0), (1, 0), (2, 0), (3, 0), (2, 1), (1, 2), (0, 3), (0, 1)],
}


def outline(points: FloatArray, faces: Sequence[Sequence[int]]) -> Counter[tuple[Any, Any]]:
    """The directed sides, by the positions of their ends, that are not met by one of the other direction."""
    sides = Counter(
        (tuple(points[start]), tuple(points[end]))
        for face in faces
        for start, end in pairwise([*face, face[0]])
        if (points[start] != points[end]).any()
    )
    return Counter(
        {side: count - sides[side[::-1]] for side, count in sides.items() if count > sides[side[::-1]]}
    )


def check(points: FloatArray, polygon: Sequence[int] | None = None, rel: float = 1e-9) -> None:
    """Cut one polygon and compare area, sides and orientation."""
    ring = list(range(len(points)) if polygon is None else polygon)
    triangles = triangulate(Polygons(points, np.array(ring), np.array([len(ring)])), len(ring))
    points = points / np.abs(points).max()  # where squares neither overflow nor vanish
    corners = points[ring] - points[ring[0]]
    normal = np.cross(corners[1:-1], corners[2:]).sum(axis=0)
    first, second, third = (points[triangles[:, corner]] for corner in range(3))
    parts = np.cross(second - first, third - first)
    area = np.linalg.norm(normal)
    assert np.linalg.norm(parts, axis=1).sum() == pytest.approx(area, rel=rel)
    assert (parts / area @ (normal / area) >= -rel).all()
    assert outline(points, triangles.tolist()) == outline(points, [ring])


def in_space(
    flat: Sequence[tuple[float, float]], turn: int = 0, scale: float = 1, shift: float = 0
) -> FloatArray:
    points = np.column_stack([np.array(flat, float), np.zeros(len(flat))])
    rotation = np.linalg.qr(np.random.default_rng(turn).normal(size=(3, 3)))[0] if turn else np.eye(3)
    spatial: FloatArray = (points @ rotation + shift) * scale
    return spatial


@pytest.mark.parametrize("name", SHAPES)
def test_letters(name: str) -> None:
    """From every first corner, in both directions, small and large, turned, and far from the origin."""
    for first in range(len(SHAPES[name])):
        shape = SHAPES[name][first:] + SHAPES[name][:first]
        for turn, scale in enumerate([1, 1e-150, 1e120, 1e-12, 1e7]):
            check(in_space(shape, turn, scale))
            check(in_space(shape[::-1], turn, scale))
        check(in_space(shape, shift=4096.5))


@st.composite
def stars(draw: st.DrawFn) -> list[tuple[float, float]]:
    """Outlines that their centre sees whole: any radii, one after the other around it."""
    radii = draw(st.lists(st.floats(0.05, 1), min_size=4, max_size=24))
    angles = np.arange(len(radii)) * 2 * np.pi / len(radii)
    return [
        (radius * np.cos(angle), radius * np.sin(angle)) for radius, angle in zip(radii, angles, strict=True)
    ]


@st.composite
def walls(draw: st.DrawFn) -> list[tuple[float, float]]:
    """Outlines that wind around themselves: a spiral, a comb or a zigzag with some width."""
    count = draw(st.integers(2, 20))
    bend, growth = draw(st.floats(-0.9, 0.9)), draw(st.floats(0.05, 0.3))
    angle = bend * np.arange(count)
    middle = (1 + growth * np.abs(angle)) if bend else np.ones(count)
    line = np.column_stack([middle * np.cos(angle), middle * np.sin(angle)])
    if draw(st.booleans()) or abs(bend) < 0.05:
        line = np.column_stack([np.arange(count), draw(st.floats(0, 3)) * (np.arange(count) % 2)])
        return [*map(tuple, line), *map(tuple, line[::-1] + np.array([0, 0.5]))]
    return [*map(tuple, line), *map(tuple, (line * 0.97)[::-1])]


@settings(max_examples=150, deadline=None)
@given(shape=stars() | walls(), turn=st.integers(0, 3), data=st.data())
def test_any_simple_polygon(shape: list[tuple[float, float]], turn: int, data: st.DataObject) -> None:
    """Also with corners on its sides, at which other faces may end."""
    sides = np.array(shape)
    if data.draw(st.booleans()):
        middles = (sides + np.roll(sides, -1, axis=0)) / 2
        sides = np.stack([sides, middles], axis=1).reshape(-1, 2)
    points = in_space(sides.tolist(), turn, data.draw(st.sampled_from([1, 1e-9, 1e9])))
    check(points[::-1] if data.draw(st.booleans()) else points, rel=1e-6)


@pytest.mark.parametrize("turn", range(3))
def test_holes_on_a_bridge(turn: int) -> None:
    """A square with two square holes as one outline, which runs to each hole and back along the same line."""
    flat = [(0, 0), (9, 0), (9, 9), (0, 9), (2, 2), (2, 4), (4, 4), (4, 2), (6, 6), (6, 8), (8, 8), (8, 6)]
    ring = [0, 4, 5, 6, 8, 9, 10, 11, 8, 6, 7, 4, 0, 1, 2, 3]
    check(in_space(flat, turn), ring)


def test_repeated_corners_and_spikes() -> None:
    points = in_space([(0, 0), (2, 0), (2, 2), (1, 1), (0, 2), (5, 5)])
    for ring in ([0, 1, 1, 2, 3, 4], [0, 0, 1, 2, 3, 4, 0], [0, 1, 2, 5, 2, 3, 4], [0, 1, 2, 3, 4, 5, 4]):
        check(points, ring)
    for ring in ([0, 1, 0, 1, 0], [3, 3, 3, 3, 3], [0, 1, 2, 1, 0]):
        assert triangulate(Polygons(points, np.array(ring), np.array([len(ring)])), 9).size == 0
    for ring in ([0, 1, 2, 2], [0, 1, 2, 0], [0, 0, 1, 2]):  # triangles that are written as quads
        check(points, ring)


@pytest.mark.parametrize("size", [4, 5, 12])
def test_polygons_that_are_not_quite_flat(size: int) -> None:
    rng = np.random.default_rng(size)
    for _ in range(50):
        angles = np.sort(rng.uniform(0, 2 * np.pi, size))
        radii = rng.uniform(0.3, 1, size) if np.diff([*angles, angles[0] + 2 * np.pi]).max() < 3 else 1
        points = in_space(list(zip(radii * np.cos(angles), radii * np.sin(angles), strict=True)))
        points[:, 2] = 1e-6 * rng.normal(size=size)
        check(points, rel=1e-4)


def test_a_strongly_bent_polygon_keeps_its_corners() -> None:
    """Seen along its normal, the side from (-5, 0, -5) to (0, 5, -5) runs back along the one before it."""
    points = np.array([[-5, 0, 5], [5, 0, 5], [5, 0, -5], [-5, 0, -5], [0, 5, -5]], np.float64)
    for first in range(5):
        corners = np.roll(np.arange(5), first)
        triangles = triangulate(Polygons(points, corners, np.array([5])), 10)
        assert len(triangles) == 3
        assert set(triangles.ravel().tolist()) == set(range(5))


def test_in_one_plane_and_without_area() -> None:
    points = in_space([(0, 0), (1, 0), (3, 0), (2, 0), (0.5, 0)])
    assert len(triangulate(Polygons(points, np.arange(5), np.array([5])), 9)) <= 3


def test_polygons_keep_their_order_and_their_fans() -> None:
    """Whatever is cut in another way stands between triangles and fans that stay as they were."""
    points = in_space([(0, 0), (2, 0), (2, 2), (1, 1), (0, 2), (4, 0), (5, 1), (4, 2)])
    polygons = [(0, 1, 2), (0, 1, 2, 3, 4), (1, 5, 7, 2), (1, 5, 6, 7, 2), (3, 4, 0, 1)]
    corners, sizes = np.concatenate(polygons), np.array([len(polygon) for polygon in polygons])
    triangles = triangulate(Polygons(points, corners, sizes), 99).tolist()
    assert triangles[0] == [0, 1, 2]
    assert {*triangles[1], *triangles[2], *triangles[3]} == {0, 1, 2, 3, 4}
    assert triangles[4:9] == [[1, 5, 7], [7, 2, 1], [1, 5, 6], [1, 6, 7], [1, 7, 2]]


def test_first_halves_of_quads_come_first() -> None:
    points = in_space([(0, 0), (2, 1), (4, 0), (2, 4), (9, 9)])
    quads = np.array([[0, 1, 2, 3], [0, 1, 4, 3], [1, 2, 3, 0]])
    triangles = triangulate(Polygons(points, quads.ravel(), np.full(3, 4)), 6).tolist()
    assert triangles == [[0, 1, 3], [0, 1, 4], [1, 2, 3], [1, 2, 3], [4, 3, 0], [3, 0, 1]]


def test_missing_vertices(tmp_path: Path) -> None:
    text = "OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n4 0 1 2 3\n3 0 1 4\n"
    refuse(write(tmp_path, "a.off", text), "has '3 0 1 4' in line 8", "vertices 0 to 3")
