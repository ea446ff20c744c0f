# SPDX-License-Identifier: MIT
"""Preprocessing does not depend on how a surface is cut into triangles."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import KDTree

from benchmarks.flat_parts import make_parts
from benchmarks.flat_parts.tessellations import flipped, reordered, split_in_four, tessellations
from shapegoogle_core.mesh import Mesh, face_areas, unique_edges
from shapegoogle_core.model import load_model
from shapegoogle_core.model.shape_bags import shape_bags
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.preprocessing import coarsening, preprocess, repair, separate_fans
from shapegoogle_core.preprocessing.coarsening import coarsen
from shapegoogle_core.preprocessing.ear_clipping import clip_ears, outline_around
from shapegoogle_core.preprocessing.flat_regions import flat_regions
from shapegoogle_core.preprocessing.triangulation import edge_table, flip_edges

BALL = trimesh.creation.icosphere(subdivisions=2)
BOX = trimesh.creation.box((1, 2, 3))


def mesh_of(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(shape.vertices, shape.faces, "shape")


def part(family: str) -> Mesh:
    return repair(next(make_parts([family])).mesh)


def same_places(one: Mesh, other: Mesh) -> bool:
    if len(one.vertices) != len(other.vertices):
        return False
    distance, _ = KDTree(one.vertices).query(other.vertices)
    return bool(np.max(distance) < 1e-6 * np.ptp(one.vertices))


class TestFlatRegions:
    def test_a_box_has_six_a_ball_as_many_as_faces(self) -> None:
        assert len(np.unique(flat_regions(mesh_of(BOX)))) == 6
        assert len(np.unique(flat_regions(split_in_four(mesh_of(BOX))))) == 6
        assert np.array_equal(flat_regions(mesh_of(BALL)), np.arange(len(BALL.faces)))

    def test_flat_from_face_to_face_only_is_not_flat(self) -> None:
        """A tube of 20,000 sides, whose caps are flat."""
        fine = trimesh.creation.cylinder(1, 1, sections=20_000)
        region = flat_regions(mesh_of(fine))
        sides = np.abs(fine.face_normals[:, 2]) < 0.5
        assert len(np.unique(region[sides])) == np.count_nonzero(sides)
        assert len(np.unique(region[~sides])) == 2

    def test_faces_folded_onto_each_other_are_two(self) -> None:
        corners = np.array([[0, 0, 0], [1, 0, 0], [0.2, 1, 0], [0.7, 1, 0]])
        folded = Mesh(corners, [[0, 1, 2], [1, 0, 3]])
        assert len(np.unique(flat_regions(folded))) == 2


def dented_box() -> Mesh:
    """A box of many triangles, flat but for a rough dent in one of its sides."""
    box = trimesh.creation.box((1, 1, 1)).subdivide_to_size(0.08)
    depth = np.maximum(0, 0.12 - ((box.vertices - [0.1, 0.0, 0.5]) ** 2).sum(axis=1))
    depth *= np.random.default_rng(0).uniform(0.8, 1.2, len(depth))
    return Mesh(box.vertices - depth[:, None] * [0, 0, 1], box.faces, "dented box")


class TestCoarseningAPart:
    def test_faces_of_curved_surfaces_are_left_out_and_nothing_else_changes(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        mesh = dented_box()
        faces = mesh.faces.astype(np.int64)
        edges = edge_table(faces)
        near = coarsening._near_flat_regions(faces, flat_regions(mesh, edges), edges)
        assert 0.5 < near.mean() < 1
        part = coarsen(mesh)
        monkeypatch.setattr(coarsening, "_near_flat_regions", lambda *_: np.ones(len(mesh.vertices), bool))
        whole = coarsen(mesh)
        assert np.array_equal(part[0].vertices, whole[0].vertices)
        assert np.array_equal(part[0].faces, whole[0].faces)
        assert np.array_equal(part[1], whole[1])

    def test_the_whole_mesh_is_coarsened_where_a_part_is_too_small(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        mesh = dented_box()
        expected = coarsen(mesh)[0]
        assert len(expected.vertices) < len(mesh.vertices) / 2
        # The middle of a side: its vertices may go, but not all faces of their neighbours are known.
        middle = np.abs(mesh.vertices[:, :2]).max(axis=1) < 0.3
        monkeypatch.setattr(coarsening, "_near_flat_regions", lambda *_: middle)
        assert np.array_equal(coarsen(mesh)[0].faces, expected.faces)


class TestCoarsen:
    @pytest.mark.parametrize("family", ["plate with holes", "tray", "nut", "bracket"])
    def test_back_to_the_corners(self, family: str) -> None:
        mesh = part(family)
        expected, _ = coarsen(mesh)
        for name, version in tessellations(mesh, np.random.default_rng(0)):
            after, region = coarsen(repair(version))
            assert same_places(after, expected), name
            assert after.area == pytest.approx(mesh.area, rel=1e-6)
            assert (unique_edges(after)[1] == 2).all()
            assert len(region) == len(after.faces)

    def test_curved_surface_is_left_alone(self) -> None:
        mesh = mesh_of(BALL)
        assert coarsen(mesh)[0] is mesh

    def test_open_grid_becomes_a_rectangle(self) -> None:
        x, y = np.meshgrid(np.arange(9.0), np.arange(7.0))
        corner = (np.arange(6)[:, None] * 9 + np.arange(8)).ravel()
        faces = np.concatenate(
            [np.stack([corner, corner + 1, corner + 10], 1), np.stack([corner, corner + 10, corner + 9], 1)]
        )
        after, region = coarsen(Mesh(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), faces))
        assert len(after.vertices) == 4
        assert len(after.faces) == 2
        assert np.unique(region).size == 1

    @settings(max_examples=25, deadline=None)
    @given(
        st.lists(
            st.tuples(*[st.integers(0, 26)] * 3).filter(lambda f: len(set(f)) == 3), min_size=1, max_size=40
        ),
        st.booleans(),
    )
    def test_any_faces_on_a_grid(self, faces: list[tuple[int, ...]], split: bool) -> None:
        """Overlapping, folded, non-manifold: the area stays, and no hole opens.

        Outlines that lie in one place may become one, as when vertices are welded.
        """
        grid = np.stack(np.meshgrid(*[np.arange(3.0)] * 3), axis=-1).reshape(-1, 3)
        mesh = repair(Mesh(grid, faces))
        if len(mesh.faces) == 0:
            return
        mesh = repair(split_in_four(mesh)) if split else mesh
        after, region = coarsen(mesh)
        assert len(region) == len(after.faces)
        assert after.area == pytest.approx(mesh.area)
        assert open_length(after) <= open_length(mesh) + 1e-9
        assert (face_areas(after) > 0).all()


def open_length(mesh: Mesh) -> float:
    edges, counts = unique_edges(mesh)
    lengths = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    return float(lengths[counts == 1].sum())


class TestEars:
    def test_outlines(self) -> None:
        assert outline_around(9, [(9, 1, 2), (2, 3, 9), (3, 1, 9)]) == [1, 2, 3]
        assert outline_around(9, [(2, 3, 9), (9, 1, 2)]) == [1, 2, 3]
        assert outline_around(9, [(9, 1, 2), (9, 3, 4)]) == []
        assert outline_around(9, [(9, 1, 2), (9, 1, 4)]) == []

    @pytest.mark.parametrize("seed", range(5))
    def test_star(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        angle = np.arange(12) * np.pi / 6
        points = (random.uniform(0.3, 1, 12) * np.stack([np.cos(angle), np.sin(angle)])).T
        triangles = clip_ears(range(100, 112), points, 1e-6)
        assert len(triangles) == 10
        corners = points[np.array(triangles) - 100]
        side, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        areas = side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0]
        x, y = points.T
        assert (areas > 0).all()
        assert areas.sum() == pytest.approx((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())

    def test_no_area_no_triangles(self) -> None:
        assert clip_ears([0, 1, 2, 3], np.array([[0.0, 0], [1, 0], [2, 0], [3, 0]]), 1e-6) == []


class TestFlips:
    @pytest.mark.parametrize("family", ["gear", "small plate"])
    def test_delaunay_from_any_diagonals(self, family: str) -> None:
        mesh = part(family)
        region = flat_regions(mesh)
        for seed in range(3):
            version = flipped(mesh, np.random.default_rng(seed))
            assert not np.array_equal(version.faces, mesh.faces)
            after = Mesh(mesh.vertices, flip_edges(mesh.vertices, version.faces.astype(np.int64), region))
            assert after.area == pytest.approx(mesh.area)
            assert (unique_edges(after)[1] == 2).all()
            edges = edge_table(after.faces.astype(np.int64))
            inside = edges.inside(flat_regions(after))
            opposite = [angles(after)[side[inside]] for side in (edges.first, edges.last)]
            assert (opposite[0] + opposite[1] <= np.pi + 1e-6).all()


def angles(mesh: Mesh) -> np.ndarray:
    corners = mesh.vertices[mesh.faces]
    after, before = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cosine = (after * before).sum(axis=2) / np.linalg.norm(after, axis=2) / np.linalg.norm(before, axis=2)
    return np.asarray(np.arccos(np.clip(cosine, -1, 1)).ravel())


class TestFans:
    def test_balls_that_touch_come_apart(self) -> None:
        both = repair(
            Mesh(
                np.concatenate([BALL.vertices, 2 * BALL.vertices[0] - BALL.vertices]),
                np.concatenate([BALL.faces, BALL.faces[:, ::-1] + len(BALL.vertices)]),
            )
        )
        assert len(both.vertices) == 2 * len(BALL.vertices) - 1
        after = separate_fans(both)
        assert len(after.vertices) == 2 * len(BALL.vertices)
        assert np.array_equal(after.vertices[after.faces], both.vertices[both.faces])
        graph = after.faces[:, [0, 1, 1, 2]].reshape(-1, 2)
        assert len(trimesh.graph.connected_components(graph)) == 2

    def test_surfaces_stay_whole(self) -> None:
        for mesh in (mesh_of(BALL), part("tray")):
            assert separate_fans(mesh) is mesh


@pytest.mark.parametrize("family", ["sheet", "gear", "tube"])
def test_same_surface_same_bags(family: str) -> None:
    """The distance to other triangles is far below that to the next member of the family."""
    model = load_model()

    def bags(mesh: Mesh) -> np.ndarray:
        return shape_bags(model.settings, model.vocabularies, working_shape(model.settings, mesh))

    members = [member.mesh for member, _ in zip(make_parts([family]), range(2), strict=False)]
    expected = bags(members[0])
    random = np.random.default_rng(0)
    mesh = repair(members[0])
    versions = [split_in_four(mesh), reordered(split_in_four(flipped(mesh, random)), random)]
    other = float(model.distances(expected, bags(members[1])[None])[0])
    for version in versions:
        assert preprocess(version).area == pytest.approx(preprocess(mesh).area, rel=0.003)
        distance = float(model.distances(expected, bags(version)[None])[0])
        assert distance < min(0.02, 0.5 * other)
