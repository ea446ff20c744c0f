# SPDX-License-Identifier: MIT
"""Repeatability: where points came from, distances along the surface, and what chance would give."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.experiments.keypoint_repeatability import (
    NullShape,
    found_points,
    places_on_null,
    repeatability,
)
from shapegoogle_core.keypoints import DETECTORS
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import PRESETS
from shapegoogle_core.model.augmentation import TRANSFORMATIONS, scale_factor, transform
from tests.core.conftest import Shapes


@pytest.fixture(scope="module")
def null(shapes: type[Shapes]) -> NullShape:
    return NullShape(shapes.bumpy(4))


class TestNullShape:
    def test_diameter_of_a_sphere(self, shapes: type[Shapes]) -> None:
        assert NullShape(shapes.sphere(4)).diameter == pytest.approx(math.pi, rel=0.03)

    def test_diameter_is_that_of_the_largest_part(self, shapes: type[Shapes]) -> None:
        sphere, small = shapes.sphere(3), shapes.sphere(2)
        both = Mesh(
            np.concatenate([0.1 * small.vertices + 3, sphere.vertices]),
            np.concatenate([small.faces, sphere.faces + len(small.vertices)]),
        )
        assert NullShape(both).diameter == pytest.approx(math.pi, rel=0.05)

    def test_near_is_a_cap_of_a_sphere(self, shapes: type[Shapes]) -> None:
        sphere = NullShape(shapes.sphere(4))
        near = sphere.near(np.array([0]), tolerance=0.1)
        angle = np.arccos(np.clip(sphere.mesh.vertices @ sphere.mesh.vertices[0], -1, 1))
        assert angle[near].max() < 0.1 * math.pi * 1.03
        assert angle[~near].min() > 0.1 * math.pi * 0.93

    def test_across_a_gap_is_far(self, shapes: type[Shapes]) -> None:
        """Two sheets a hair apart, joined at one side only: near in space, far along the surface."""
        width, cells = 2.0, 40
        sheet = shapes.rectangle(width, 0.5, cells)
        x, y, _ = sheet.vertices.T
        folded = np.stack([np.abs(x - width / 2), y, np.where(x < width / 2, 0, 0.01)], axis=1)
        near = NullShape(Mesh(folded, sheet.faces)).near(np.array([0]), tolerance=0.2)
        assert near[0]
        assert not near[x > width / 2].any()


class TestPlaces:
    @pytest.mark.parametrize("kind", TRANSFORMATIONS)
    def test_every_vertex_is_found_where_it_came_from(self, null: NullShape, kind: str) -> None:
        query = transform(null.mesh, kind, 3, seed=1)
        places = places_on_null(null.mesh, query, kind, 3, query.vertices)
        origin = null.mesh.vertices[places] * scale_factor(kind, 3)
        moved = np.linalg.norm(origin - query.vertices, axis=1) / np.linalg.norm(np.ptp(origin, axis=0))
        if kind in ("micro_holes", "holes", "partial", "scale"):
            assert moved.max() < 1e-12
        elif kind in ("sampling", "mixed", "topology", "noise"):
            assert np.median(moved) < 0.01
        if len(query.vertices) == len(null.mesh.vertices):
            assert np.array_equal(places, np.arange(len(places)))

    def test_poses_need_the_same_vertices(self, null: NullShape, shapes: type[Shapes]) -> None:
        with pytest.raises(ValueError, match="does not have the vertices of"):
            places_on_null(null.mesh, shapes.bumpy(2), "isometry", 1, np.zeros((1, 3)))

    def test_poses_keep_the_order(self, null: NullShape) -> None:
        stretched = Mesh(null.mesh.vertices * [1, 2, 1], null.mesh.faces)
        places = places_on_null(null.mesh, stretched, "isometry", 1, stretched.vertices[[5, 7]])
        assert places.tolist() == [5, 7]


class TestRepeatability:
    def test_shares_by_hand(self, null: NullShape) -> None:
        points = null.mesh.vertices[[3]]
        far = int(np.linalg.norm(null.mesh.vertices - points, axis=1).argmax())
        measured = repeatability(null, points, np.array([3, far, 3, far]))
        assert (measured.points, measured.repeated) == (4, 0.5)
        assert 0 < measured.chance < 0.01

    def test_who_marks_everything_finds_everything(self, null: NullShape) -> None:
        everything = np.arange(len(null.mesh.vertices))
        measured = repeatability(null, null.mesh.vertices, everything)
        assert measured.repeated == 1
        assert measured.chance == pytest.approx(1)

    def test_without_points(self, null: NullShape) -> None:
        nothing = np.empty((0, 3))
        assert repeatability(null, nothing, np.array([0, 1])).repeated == 0
        assert math.isnan(repeatability(null, nothing, np.empty(0, np.int64)).repeated)

    def test_the_shape_itself_and_a_larger_copy(self, null: NullShape) -> None:
        settings = PRESETS["default"]
        known = found_points(settings, null.mesh)
        assert list(known) == list(DETECTORS)
        larger = transform(null.mesh, "scale", 5, seed=0)
        for detector, points in found_points(settings, larger).items():
            assert len(points) > 0
            places = places_on_null(null.mesh, larger, "scale", 5, points)
            assert repeatability(null, known[detector], places).repeated == 1
