# SPDX-License-Identifier: MIT
"""Measures of meshes: moments known in closed form, and what tells copies from other shapes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from benchmarks.creatures import make_creature
from benchmarks.experiments.evidence_pairs import remeshed
from benchmarks.flat_parts import FAMILIES, make_part_pairs
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.registration import (
    MeshMeasures,
    handed_alike,
    is_same_mesh,
    is_same_place,
    is_same_size,
    measure_mesh,
    principal_motions,
    surface_difference,
)


def measured(mesh: Mesh) -> MeshMeasures:
    measures = measure_mesh(mesh)
    assert measures is not None
    return measures


def bracket() -> Mesh:
    """A solid without any symmetry."""
    return make_part_pairs("bracket")[0].query


def moved(mesh: Mesh, seed: int, scale: float = 1.0, flip: float = 1.0) -> tuple[Mesh, np.ndarray]:
    turn = Rotation.random(random_state=seed).as_matrix() @ np.diag([flip, 1, 1])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = scale * turn, np.random.default_rng(seed).normal(size=3) * 50
    return Mesh(mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3], mesh.faces), matrix


def test_moments_of_a_box_are_those_of_the_formula() -> None:
    box = trimesh.creation.box((2, 2, 2))
    box.apply_translation((5, 6, 7))
    measures = measured(Mesh(box.vertices, box.faces))
    assert measures.area == pytest.approx(24)
    assert measures.center == pytest.approx([5, 6, 7])
    # Mean of x² over the cube |x|, |y|, |z| ≤ 1: on two faces 1, on four 1/3; over the area.
    assert measures.second == pytest.approx(np.array([1, 0, 0, 1, 0, 1]) * (5 / 9) / 24)
    assert measures.normals == pytest.approx(np.array([1, 0, 0, 1, 0, 1]) / 3)
    # On a face: mean of (1 + y² + z²)² = 1 + 4/3 + 2/5 + 2/9, and of (x · n)² = 1.
    assert measures.fourth == pytest.approx((1 + 4 / 3 + 2 / 5 + 2 / 9) / 24**2)
    assert measures.support == pytest.approx(1 / 24)
    assert measures.coarseness == 0


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 1000), st.floats(0.1, 10), st.booleans())
def test_copies_are_recognised_wherever_they_are(seed: int, scale: float, flip: bool) -> None:
    mesh = bracket()
    random = np.random.default_rng(seed)
    order = random.permutation(len(mesh.vertices))
    shuffled = Mesh(mesh.vertices[order], np.argsort(order)[mesh.faces][random.permutation(len(mesh.faces))])
    copy, matrix = moved(shuffled, seed, scale, -1 if flip else 1)
    own, other = measured(mesh), measured(copy)
    assert is_same_mesh(own, other)
    assert is_same_size(own, other) == (abs(scale - 1) < 1e-5)
    assert handed_alike(own, other) is not flip
    assert is_same_place(own, measured(shuffled))
    # The measures can be moved like the mesh.
    predicted = own.moved(matrix)
    assert is_same_place(predicted, other)
    assert predicted.twist == pytest.approx(other.twist, abs=1e-9)


def test_a_vertex_that_has_moved_a_little_makes_another_mesh() -> None:
    mesh = make_creature("horse", 0).pose(0)
    vertices = mesh.vertices.copy()
    vertices[100] += 1e-3 * np.sqrt(mesh.area) * np.array([0.6, 0.8, 0])
    assert not is_same_mesh(measured(mesh), measured(Mesh(vertices, mesh.faces)))
    rounded = Mesh(mesh.vertices.astype(np.float32), mesh.faces)
    assert is_same_mesh(measured(mesh), measured(rounded))
    assert is_same_place(measured(mesh), measured(rounded))


@pytest.mark.parametrize("family", ["plate with holes", "bracket", "tray", "nut"])
def test_parts_of_other_sizes_are_other_surfaces_and_other_triangles_are_not(family: str) -> None:
    assert family in FAMILIES
    for pair in make_part_pairs(family):
        own, other = measured(pair.query), measured(pair.candidate)
        difference, tolerance = surface_difference(own, other)
        assert (difference <= tolerance) == (pair.kind != "different"), pair.detail
        copied = pair.kind in ("identical", "moved", "scaled", "mirrored")
        assert is_same_mesh(own, other) == copied, pair.detail
        if copied:
            assert is_same_place(own, other) == (pair.kind == "identical"), pair.detail
            assert (handed_alike(own, other) is False) == (pair.kind == "mirrored"), pair.detail


def gear(teeth: int, turned: float = 0.0) -> Mesh:
    """A toothed ring; as many corners for each tooth."""
    angles = turned + np.arange(4 * teeth) * np.pi / (2 * teeth)
    radii = np.where(np.arange(4 * teeth) % 4 < 2, 20.0, 22.0)
    outline = np.c_[radii * np.cos(angles), radii * np.sin(angles)]
    around = np.arange(4 * teeth)
    after = np.roll(around, -1)
    points = np.concatenate([np.c_[outline, np.full(len(outline), z)] for z in (0.0, 5.0)] + [[[0, 0, 5.0]]])
    upper = len(outline)
    sides = [np.c_[around, after, after + upper], np.c_[around, after + upper, around + upper]]
    lid = np.c_[around + upper, after + upper, np.full(len(around), 2 * upper)]
    return Mesh(points, np.concatenate([*sides, lid]))


@pytest.mark.parametrize("teeth", [5, 24])
def test_a_symmetric_part_that_is_turned_by_less_than_its_symmetry_is_elsewhere(teeth: int) -> None:
    own = measured(gear(teeth))
    for turned, same in ((0.05, False), (1e-4, False), (2 * np.pi / teeth, True), (0.0, True)):
        other = measured(gear(teeth, turned))
        assert is_same_mesh(own, other)
        assert is_same_place(own, other) == same, turned
    # Nobody knows where it is once its measures were moved without its mesh.
    quarter = np.eye(4)
    quarter[:2, :2] = [[0, -1], [1, 0]]
    assert not is_same_place(own.moved(quarter), measured(gear(teeth, np.pi / 2)))


def box(extents: Sequence[float], center: Sequence[float] = (0, 0, 0)) -> Mesh:
    made = trimesh.creation.box(extents)
    return Mesh(np.asarray(made.vertices) + center, made.faces)


def joined(meshes: Sequence[Mesh]) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def fan(tilt: float) -> list[Mesh]:
    blade = box((30, 8, 1))
    tilted = blade.vertices @ Rotation.from_rotvec([tilt, 0, 0]).as_matrix().T + np.array([22, 0, 0])
    turns = (Rotation.from_rotvec([0, 0, number * np.pi / 2]).as_matrix() for number in range(4))
    return [Mesh(tilted @ turn.T, blade.faces) for turn in turns]


HANDED = {
    "two lugs": [box((20, 10, 5)), box((4, 4, 8), (6, 2, 6)), box((8, 3, 4), (-4, -3, 4))],
    "bracket with a stud": [box((60, 30, 5)), box((5, 30, 40), (-27, 0, 22)), box((4, 4, 4), (10, 8, 4))],
    "small stud on a square plate": [box((100, 100, 6)), box((4, 4, 2), (-30, 15, 4))],
    "stairs": [box((2, 60, 30), (9, 25, 12)), *(box((20, 10, 4), (0, 10 * n, 4 * n)) for n in range(6))],
    "fan": fan(0.5),
    "fan that is almost flat": fan(0.02),
}


@pytest.mark.parametrize("name", HANDED)
def test_left_and_right_parts_are_mirror_images(name: str) -> None:
    mesh = joined(HANDED[name])
    own = measured(mesh)
    for flip in (1.0, -1.0):
        copy, _ = moved(mesh, 5, 1.0, flip)
        other = measured(Mesh(copy.vertices.astype(np.float32), copy.faces))
        assert is_same_mesh(own, other)
        assert handed_alike(own, other) == (flip > 0)


def test_a_part_that_is_its_own_mirror_image_is_neither_left_nor_right() -> None:
    mesh = Mesh(*_cube())
    own = measured(mesh)
    # Its moments are those of its mirror image, and so are the triangles of an icosphere.
    assert np.abs(own.handedness[:, 0]).max() < 1e-12
    ball = trimesh.creation.icosphere(2)
    own = measured(Mesh(np.asarray(ball.vertices), ball.faces))
    copy, _ = moved(Mesh(np.asarray(ball.vertices), ball.faces), 3, 1.0, -1)
    assert handed_alike(own, measured(copy)) is None


def test_another_mesh_of_a_curved_surface_is_within_the_tolerance_and_another_pose_is_not() -> None:
    creature = make_creature("horse", 0)
    mesh = creature.pose(0)
    own = measured(mesh)
    difference, tolerance = surface_difference(own, measured(remeshed(mesh, np.random.default_rng(0))))
    assert difference <= tolerance
    difference, tolerance = surface_difference(own, measured(creature.pose(3)))
    assert difference > tolerance


@pytest.mark.parametrize("reflected", [False, True])
def test_principal_motions_hold_the_true_one(reflected: bool) -> None:
    mesh = bracket()
    copy, matrix = moved(mesh, 7, 1.5, -1 if reflected else 1)
    motions = principal_motions(measured(copy), measured(mesh), reflected=reflected)
    assert len(motions) == 4
    errors = [np.abs(scale * turn - matrix[:3, :3]).max() for scale, turn, _ in motions]
    scale, turn, shift = motions[int(np.argmin(errors))]
    assert scale * mesh.vertices @ turn.T + shift == pytest.approx(copy.vertices, abs=1e-5)
    assert principal_motions(measured(Mesh(*_cube())), measured(mesh)) == []


def _cube() -> tuple[np.ndarray, np.ndarray]:
    box = trimesh.creation.box()
    return box.vertices, box.faces


def test_measures_survive_storage_and_those_of_another_version_are_not_known() -> None:
    own = measured(bracket())
    back = MeshMeasures.from_bytes(own.to_bytes())
    assert back is not None
    assert back.to_bytes() == own.to_bytes()
    assert is_same_mesh(own, back)
    assert MeshMeasures.from_bytes(own.to_bytes()[:-8]) is None


def test_clouds_and_shapes_without_area_have_measures_or_none() -> None:
    points = np.random.default_rng(0).normal(size=(200, 3))
    own, other = measured(Mesh(points)), measured(Mesh(points[::-1]))
    assert own.hash == other.hash
    assert is_same_mesh(own, other)
    assert is_same_place(own, other)
    assert np.isinf(own.coarseness)
    assert own.chirality == 0
    assert measure_mesh(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])) is None
    assert measure_mesh(Mesh(np.zeros((5, 3)))) is None
