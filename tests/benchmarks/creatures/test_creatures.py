# SPDX-License-Identifier: MIT
"""Creatures: closed surfaces, poses that keep lengths, and what their skeletons do."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from benchmarks.creatures import CREATURE_KINDS, Creature, make_creature
from benchmarks.creatures.skeleton import Pose, Skeleton, SkeletonBuilder, Wave
from benchmarks.creatures.skinning import pose_vertices
from benchmarks.creatures.surface import is_closed_manifold
from shapegoogle_core import Mesh, MeshError
from shapegoogle_core.mesh import unique_edges
from shapegoogle_core.mesh.mesh import FloatArray

pytest.importorskip("skimage", reason="creatures need the optional extra 'demo'")


@cache
def creature(kind: str, seed: int = 0) -> Creature:
    return make_creature(kind, seed)


def edge_changes(before: Mesh, after: Mesh) -> FloatArray:
    edges, _ = unique_edges(before)
    lengths = [
        np.linalg.norm(m.vertices[edges[:, 0]] - m.vertices[edges[:, 1]], axis=1) for m in (before, after)
    ]
    return np.asarray(np.abs(lengths[1] / lengths[0] - 1))


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_there_are_enough_kinds() -> None:
    assert len(set(CREATURE_KINDS)) == len(CREATURE_KINDS) >= 16


@pytest.mark.parametrize("kind", CREATURE_KINDS)
class TestEveryKind:
    def test_is_one_closed_surface_facing_outward(self, kind: str) -> None:
        mesh = creature(kind).rest
        assert abs(len(mesh.vertices) - 3000) <= 30
        assert is_closed_manifold(mesh)
        edges, _ = unique_edges(mesh)
        links = coo_array((np.ones(len(edges)), edges.T), shape=(len(mesh.vertices),) * 2)
        assert connected_components(links, directed=False)[0] == 1
        assert volume(mesh) > 0

    def test_poses_keep_faces_and_nearly_all_lengths(self, kind: str) -> None:
        individual = creature(kind)
        assert len(individual.pose_names) >= 5
        changes = []
        for pose in (*individual.pose_names, *range(4)):
            posed = individual.pose(pose)
            np.testing.assert_array_equal(posed.faces, individual.rest.faces)
            changes.append(np.median(edge_changes(individual.rest, posed)))
            # Dual quaternions keep the volume; a collapsed joint or a torn part would not.
            assert 0.8 < volume(posed) / volume(individual.rest) < 1.2
        assert np.median(changes) < 0.03
        assert max(changes) < 0.07

    def test_poses_differ(self, kind: str) -> None:
        individual = creature(kind)
        size = np.ptp(individual.rest.vertices, axis=0).max()
        poses = [individual.pose(name).vertices for name in individual.pose_names]
        for first in range(len(poses)):
            for second in range(first):
                assert np.linalg.norm(poses[first] - poses[second], axis=1).max() > 0.05 * size

    def test_weights_are_shares(self, kind: str) -> None:
        weights = creature(kind).weights
        assert (weights >= 0).all()
        np.testing.assert_allclose(weights.sum(axis=1), 1)


@pytest.mark.parametrize("kind", CREATURE_KINDS[::6])
def test_individuals_differ(kind: str) -> None:
    one, other = creature(kind).rest, make_creature(kind, 1).rest
    sizes = [np.ptp(mesh.vertices, axis=0) / np.sqrt(mesh.area) for mesh in (one, other)]
    assert np.abs(sizes[0] / sizes[1] - 1).max() > 0.01


def test_same_seed_gives_the_same_creature_and_pose() -> None:
    one, again = make_creature("spider", 7), make_creature("spider", 7)
    np.testing.assert_array_equal(one.rest.vertices, again.rest.vertices)
    np.testing.assert_array_equal(one.rest.faces, again.rest.faces)
    np.testing.assert_array_equal(one.pose(3).vertices, again.pose(3).vertices)
    assert not np.allclose(one.pose(3).vertices, one.pose(4).vertices)


def test_names_tell_kind_seed_and_pose() -> None:
    assert creature("dog").rest.name == "dog-0"
    assert creature("dog").pose("sit").name == "dog-0-sit"
    assert creature("dog").pose(5).name == "dog-0-5"


@pytest.mark.parametrize("vertex_count", [1200, 6000])
def test_vertex_count_is_met(vertex_count: int) -> None:
    mesh = make_creature("lizard", 2, vertex_count).rest
    assert abs(len(mesh.vertices) / vertex_count - 1) <= 0.01
    assert is_closed_manifold(mesh)


def test_rest_pose_is_the_rest_mesh() -> None:
    individual = creature("crab")
    np.testing.assert_allclose(individual.pose("rest").vertices, individual.rest.vertices, atol=1e-12)


def test_one_leg_does_not_drag_the_other() -> None:
    individual = creature("human")
    skeleton, rest = individual.skeleton, individual.rest
    angles = skeleton.angles({"leg.L": [(-60.0, 20.0, 0.0), (50.0, 0.0, 0.0)]})
    moved = np.linalg.norm(
        pose_vertices(skeleton, individual.weights, rest.vertices, angles) - rest.vertices, axis=1
    )
    knee = skeleton.bones[skeleton.chains()["leg.L"][1]].head
    low = rest.vertices[:, 2] < knee[2]
    left, right = low & (rest.vertices[:, 0] > 0), low & (rest.vertices[:, 0] < 0)
    height = np.ptp(rest.vertices[:, 2])
    assert moved[right].max() < 5e-3 * height
    assert moved[left].min() > 0.05 * height


def test_turning_the_root_moves_rigidly() -> None:
    individual = creature("horse")
    angles = individual.skeleton.angles({"spine": [(40.0, 30.0, -70.0)]})
    vertices = pose_vertices(individual.skeleton, individual.weights, individual.rest.vertices, angles)
    assert edge_changes(individual.rest, Mesh(vertices, individual.rest.faces)).max() < 1e-9


def test_both_sides_move_as_mirror_images() -> None:
    individual = creature("bird")
    for name in ("rest", "wings up", "fold"):
        x = individual.pose(name).vertices[:, 0]
        assert abs(x.max() + x.min()) < 0.03 * np.ptp(x)


def test_unknown_names_are_refused() -> None:
    with pytest.raises(ValueError, match=r"no creature kind 'unicorn'; there are human"):
        make_creature("unicorn", 0)
    with pytest.raises(ValueError, match=r"a dog has no pose 'fly'; it has rest, walk"):
        creature("dog").pose("fly")


def test_missing_scikit_image_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "skimage.measure", None)
    with pytest.raises(ImportError, match=r"scikit-image.*'demo'"):
        make_creature("dog", 0)


class TestSkeleton:
    @staticmethod
    def skeleton(poses: Mapping[str, Pose] | None = None) -> Skeleton:
        builder = SkeletonBuilder()
        builder.chain("spine", [[0, 0, 0], [0, 0, 1], [0, 0, 2]], [0.2, 0.2, 0.2], toward=(0, -1, 0))
        builder.chain(
            "arm", [[0.2, 0, 2], [1, 0, 2]], [0.1, 0.1], parent="spine.1", toward=(0, -1, 0), both_sides=True
        )
        return builder.build(dict(poses or {}))

    @staticmethod
    def move(skeleton: Skeleton, pose: Pose, point: list[float], bone: int) -> FloatArray:
        weights = np.zeros((1, len(skeleton.bones)))
        weights[0, bone] = 1
        moved = pose_vertices(skeleton, weights, np.array([point], float), skeleton.angles(pose))
        return np.asarray(moved[0])

    def test_bend_turns_toward_the_given_direction(self) -> None:
        skeleton = self.skeleton()
        np.testing.assert_allclose(
            self.move(skeleton, {"spine": [(90, 0, 0)]}, [0, 0, 1], 0), [0, -1, 0], atol=1e-12
        )
        left = self.move(skeleton, {"arm": (90, 0, 0)}, [1.2, 0, 2], 2)
        right = self.move(skeleton, {"arm": (90, 0, 0)}, [-1.2, 0, 2], 3)
        np.testing.assert_allclose(left, [0.2, -1, 2], atol=1e-12)
        np.testing.assert_allclose(right, left * [-1, 1, 1], atol=1e-12)

    def test_swing_is_mirrored(self) -> None:
        skeleton = self.skeleton()
        left = self.move(skeleton, {"arm": (0, 30, 10)}, [1.2, 0.3, 2], 2)
        right = self.move(skeleton, {"arm": (0, 30, 10)}, [-1.2, 0.3, 2], 3)
        np.testing.assert_allclose(right, left * [-1, 1, 1], atol=1e-12)

    def test_children_follow_their_parent(self) -> None:
        moved = self.move(self.skeleton(), {"spine": (90, 0, 0)}, [0, 0, 2], 1)
        # Two bones of length 1, each turned by 45° more than the one before.
        expected = [0, -np.sin(np.pi / 4) - 1, np.cos(np.pi / 4)]
        np.testing.assert_allclose(moved, expected, atol=1e-12)

    def test_wave_rises_and_falls(self) -> None:
        angles = Wave(swing=60, cycles=1).angles(8)
        assert angles[:4, 1].min() > 0 > angles[4:, 1].max()
        np.testing.assert_allclose(angles[:, 1].sum(), 0, atol=1e-9)
        np.testing.assert_allclose(angles[:4, 1].sum(), 60, rtol=0.05)
        assert not angles[:, [0, 2]].any()

    def test_poses_must_name_chains_that_exist(self) -> None:
        with pytest.raises(KeyError, match="no chain 'tail'"):
            self.skeleton({"wag": {"tail": (0, 10, 0)}})


class TestIsClosedManifold:
    tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)

    def test_closed(self) -> None:
        assert is_closed_manifold(Mesh(self.corners, self.tetrahedron))

    def test_open(self) -> None:
        assert not is_closed_manifold(Mesh(self.corners, self.tetrahedron[1:]))

    def test_two_solids_that_share_a_vertex(self) -> None:
        second = np.where(self.tetrahedron == 0, 0, self.tetrahedron + 3)
        mesh = Mesh(np.vstack([self.corners, -self.corners[1:]]), np.vstack([self.tetrahedron, second]))
        assert not is_closed_manifold(mesh)

    def test_unused_vertex(self) -> None:
        assert not is_closed_manifold(Mesh(np.vstack([self.corners, [[5, 5, 5]]]), self.tetrahedron))


def test_impossible_numbers_of_vertices() -> None:
    with pytest.raises(ValueError, match="at least 500 vertices, not 40"):
        make_creature("spider", 0, vertex_count=40)
    with pytest.raises(MeshError, match=r"at most about \d+ vertices, not 900000"):
        make_creature("whale", 0, vertex_count=900_000)
