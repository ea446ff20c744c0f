# SPDX-License-Identifier: MIT
"""Procedural objects: every kind gives sound individuals that differ, the same ones each time."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.things import THING_KINDS, make_thing
from benchmarks.things.part import box, curve, cylinder, join, lathe, loft, tube
from shapegoogle_core import Mesh
from shapegoogle_core.mesh.measures import face_areas


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize("kind", THING_KINDS)
def test_individuals_are_sound_and_differ(kind: str) -> None:
    first, second = make_thing(kind, 0), make_thing(kind, 1)
    for mesh in (first, second):
        assert len(mesh.faces) >= 12
        areas = face_areas(mesh)
        assert (areas > 0).mean() > 0.9
        assert np.ptp(mesh.vertices, axis=0).min() > 0
    extents = [np.ptp(mesh.vertices, axis=0) for mesh in (first, second)]
    assert np.abs(extents[0] / extents[1] - 1).max() > 0.01


def test_a_seed_gives_the_same_object() -> None:
    first, again = make_thing("chair", 3), make_thing("chair", 3)
    assert np.array_equal(first.vertices, again.vertices)
    assert np.array_equal(first.faces, again.faces)


def test_an_unknown_kind_is_named() -> None:
    with pytest.raises(ValueError, match="no kind of thing 'unicorn'"):
        make_thing("unicorn", 0)


def test_primitives_are_closed_and_oriented_outwards() -> None:
    pieces = {
        "box": (box(2, 3, 4), 24.0),
        "cylinder": (cylinder(1, 2, 4), 4.0),
        "square tube": (tube([[0, 0, 0], [0, 0, 5]], 1, 4), 10.0),
        "lathe": (lathe([(0, 0), (1, 0), (1, 1), (0, 1)], 4), 2.0),
        "pyramid": (box(2, 2, 3, top=0), 4.0),
    }
    for name, (part, expected) in pieces.items():
        assert volume(Mesh(part.vertices, part.faces)) == pytest.approx(expected), name


def test_mirroring_keeps_the_orientation() -> None:
    mirrored = box(1, 1, 1).at(1).scaled(x=-1)
    assert volume(Mesh(mirrored.vertices, mirrored.faces)) == pytest.approx(1)
    both = join([mirrored, box(1, 1, 1)])
    assert volume(Mesh(both.vertices, both.faces)) == pytest.approx(2)


def test_curves_go_through_their_ends_and_do_not_overshoot() -> None:
    points = curve([(0, 0), (1, 0.5), (1, 3)], 20)
    assert points[0] == pytest.approx([0, 0])
    assert points[-1] == pytest.approx([1, 3])
    assert points[:, 0].max() <= 1 + 1e-12


def test_a_loft_without_caps_is_open() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    assert len(loft([square, square + np.array([0, 0, 1])], caps=False).faces) == 8
