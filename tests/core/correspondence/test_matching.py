# SPDX-License-Identifier: MIT
"""Matching vertices: known maps are found again, symmetry is reported, odd input does not crash."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from benchmarks.creatures import Creature, make_creature
from shapegoogle_core import Mesh, MeshError, VertexMatch, match_vertices
from shapegoogle_core.correspondence import SurfaceSettings, match_with_points
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.preprocessing.resampling import simplify
from shapegoogle_core.preprocessing.subdivision import subdivide
from tests.core.conftest import Shapes

# Small copies, so that a test takes a second; the defaults are measured by the benchmark.
QUICK = SurfaceSettings(floor=600, budget=1200, eigenpairs=60, samples=500, compared=200)


def images(match: VertexMatch, b: Mesh) -> FloatArray:
    points: FloatArray = np.einsum("pi,pid->pd", match.weights, b.vertices[b.faces[match.face]])
    return points


def errors(match: VertexMatch, b: Mesh, truth: FloatArray) -> FloatArray:
    """Straight distances in units of √area."""
    distances: FloatArray = np.linalg.norm(images(match, b) - truth, axis=1) / np.sqrt(b.area)
    return distances


def turned(mesh: Mesh, scale: float = 2.5) -> Mesh:
    """The mesh elsewhere, turned and scaled."""
    turn = trimesh.transformations.random_rotation_matrix(np.array([0.3, 0.6, 0.9]))[:3, :3]
    return Mesh(scale * mesh.vertices @ turn.T + [3, -1, 2], mesh.faces, "turned")


@pytest.fixture(scope="module")
def creature() -> Creature:
    return make_creature("horse", 102, 2500)


@pytest.fixture(scope="module")
def lopsided(shapes: type[Shapes]) -> Mesh:
    """A shape like itself in one way only; a sphere with bumps is nearly like its mirror images."""
    mesh = shapes.bumpy(3, seed=3)
    x = mesh.vertices[:, :1]
    return Mesh(mesh.vertices * [1, 1.3, 2] * (1 + 1.5 * np.maximum(x, 0) ** 2), mesh.faces, "lopsided")


def test_a_mesh_is_matched_with_itself(bumpy: Mesh) -> None:
    match = match_vertices(bumpy, bumpy, QUICK)
    assert (match.vertex == np.arange(len(bumpy.vertices))).mean() > 0.99
    assert errors(match, bumpy, bumpy.vertices).max() < 0.02
    assert match.confidence.min() > 0.9
    assert match.orientation > 0.9
    assert match.orthogonality < 0.05
    assert match.commutativity < 0.05
    assert match.area_distortion < 0.05


def test_a_permuted_copy_gives_the_permutation(bumpy: Mesh) -> None:
    random = np.random.default_rng(0)
    order = random.permutation(len(bumpy.vertices))  # vertex i of the copy is vertex order[i]
    place = np.argsort(order)
    copy = turned(Mesh(bumpy.vertices[order], place[random.permutation(bumpy.faces)]))
    match = match_vertices(bumpy, copy, QUICK)
    assert (match.vertex == place).mean() > 0.99


@pytest.mark.parametrize("size", [700, 5000])
def test_another_pose_and_another_mesh(creature: Creature, size: int) -> None:
    first, second = creature.pose(1), creature.pose(2)
    other = subdivide(second, size) if size > 2500 else simplify(second, size)
    match = match_vertices(first, turned(other), QUICK)
    off = errors(match, turned(other), turned(second).vertices)
    assert off.mean() < 0.03
    assert (off < 0.1).mean() > 0.97
    assert match.confidence.mean() > 0.7
    assert match.weights.min() >= 0
    np.testing.assert_allclose(match.weights.sum(axis=1), 1)
    nearest = other.faces[match.face][np.arange(len(match.face)), match.weights.argmax(axis=1)]
    assert (match.vertex == nearest).all()


def test_a_symmetric_shape_is_reported_and_its_sides_are_kept(creature: Creature) -> None:
    match = match_vertices(creature.rest, creature.pose(1), QUICK)
    assert match.symmetric
    assert match.orientation > 0.8
    assert errors(match, creature.pose(1), creature.pose(1).vertices).mean() < 0.03


def test_a_mirrored_copy_is_reported_as_symmetric(creature: Creature) -> None:
    """Nothing tells a mirrored symmetric shape from one whose left and right were exchanged."""
    rest = creature.rest
    mirrored = Mesh(rest.vertices * [1, -1, 1], rest.faces[:, ::-1], "mirrored")
    match = match_vertices(rest, mirrored, QUICK)
    assert match.symmetric
    assert match.distortion < 0.05


def test_a_mirrored_copy_of_an_asymmetric_shape_is_still_matched(lopsided: Mesh) -> None:
    mirrored = Mesh(lopsided.vertices * [1, -1, 1], lopsided.faces[:, ::-1], "mirrored")
    match = match_vertices(lopsided, mirrored, QUICK)
    assert match.orientation < -0.9
    assert not match.symmetric
    assert errors(match, mirrored, mirrored.vertices).mean() < 0.02


def test_an_asymmetric_shape_is_not_called_symmetric(lopsided: Mesh) -> None:
    assert not match_vertices(lopsided, turned(lopsided), QUICK).symmetric


def test_faces_turned_at_random_do_not_matter(bumpy: Mesh) -> None:
    faces = bumpy.faces.copy()
    flipped = np.random.default_rng(1).random(len(faces)) < 0.5
    faces[flipped] = faces[flipped, ::-1]
    match = match_vertices(Mesh(bumpy.vertices, faces), turned(bumpy), QUICK)
    assert match.orientation > 0.9
    assert errors(match, turned(bumpy), turned(bumpy).vertices).mean() < 0.02


def test_loose_parts_are_matched_with_their_own(bumpy: Mesh) -> None:
    """Two eyes beside a head; they are where they are relative to it."""
    ball = trimesh.creation.icosphere(2, radius=0.2)
    parts = [bumpy.vertices, *(ball.vertices + np.array([1.3, y, 0]) for y in (0.4, -0.4))]
    count = len(bumpy.vertices)
    faces = [bumpy.faces, ball.faces + count, ball.faces + count + len(ball.vertices)]
    whole = Mesh(np.concatenate(parts), np.concatenate(faces), "head")
    match = match_vertices(whole, turned(whole), QUICK)
    off = errors(match, turned(whole), turned(whole).vertices)
    assert off[:count].mean() < 0.02
    for start in (count, count + len(ball.vertices)):
        eye = slice(start, start + len(ball.vertices))
        assert off[eye].mean() < 0.1
        assert (np.abs(match.vertex[eye] - start - 40) < len(ball.vertices)).mean() > 0.9


def test_many_loose_parts_do_not_crash() -> None:
    boxes = [trimesh.creation.box().apply_translation([2 * i, i % 3, 0]) for i in range(80)]
    soup = trimesh.util.concatenate(boxes)
    assert isinstance(soup, trimesh.Trimesh)
    mesh = Mesh(soup.vertices, soup.faces, "boxes")
    match = match_vertices(mesh, turned(mesh), QUICK)
    assert np.isfinite(match.confidence).all()
    assert (match.vertex >= 0).all()


def test_an_open_shape(shapes: type[Shapes]) -> None:
    sheet = shapes.rectangle(1.0, 0.6, 20)
    x, y, _ = sheet.vertices.T
    bent = Mesh(np.stack([np.sin(x), y, np.cos(x)], axis=1), sheet.faces, "bent")
    match = match_vertices(sheet, bent, QUICK)
    assert match.orientation == 0  # neither side is inside
    assert match.symmetric
    # Any of the four symmetries of a rectangle will do.
    options = [
        bent.vertices[np.argmin(np.linalg.norm(sheet.vertices[:, None] - other[None], axis=2), axis=1)]
        for other in (np.stack([a, b, 0 * x], axis=1) for a in (x, 1 - x) for b in (y, 0.6 - y))
    ]
    assert min(errors(match, bent, truth).mean() for truth in options) < 0.03


def test_loose_vertices_and_degenerate_faces(bumpy: Mesh) -> None:
    count = len(bumpy.vertices)
    vertices = np.concatenate([bumpy.vertices, [[9.0, 9, 9], bumpy.vertices[0]]])
    faces = np.concatenate([bumpy.faces, [[0, 1, count + 1]]])
    match = match_vertices(Mesh(vertices, faces), Mesh(vertices, faces), QUICK)
    assert (match.vertex[count], match.face[count], match.confidence[count]) == (-1, -1, 0)
    assert (match.weights[count] == 0).all()
    assert errors(match, Mesh(vertices, faces), vertices)[:count].max() < 0.02
    assert match.face[:count].max() < len(bumpy.faces)  # never the face without area


def test_a_handful_of_vertices() -> None:
    box = trimesh.creation.box([1, 2, 3])
    match = match_vertices(Mesh(box.vertices, box.faces, "box"), Mesh(box.vertices, box.faces, "box"), QUICK)
    assert len(match.vertex) == 8
    assert match.symmetric


def test_anything_mesh_like_is_matched() -> None:
    box = trimesh.creation.box((1, 2, 3))
    expected = match_vertices(Mesh(box.vertices, box.faces), Mesh(box.vertices, box.faces), QUICK)
    match = match_vertices(box, (box.vertices, box.faces), QUICK)
    np.testing.assert_array_equal(match.vertex, expected.vertex)
    np.testing.assert_array_equal(match.weights, expected.weights)


def test_points_in_faces_lie_between_their_corners(bumpy: Mesh) -> None:
    match, centers = match_with_points(bumpy, turned(bumpy), np.arange(len(bumpy.faces)), QUICK)
    assert (match.vertex == np.arange(len(bumpy.vertices))).mean() > 0.99
    assert (centers.face == np.arange(len(bumpy.faces))).mean() > 0.95


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize(
    "bad",
    [
        Mesh(np.zeros((0, 3)), name="bad"),
        Mesh(np.random.default_rng(0).random((20, 3)), name="bad"),
        Mesh(np.zeros((5, 3)), [[0, 1, 2], [2, 3, 4]], name="bad"),
        Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [[0, 1, 2], [1, 2, 3]], name="bad"),
    ],
)
def test_what_is_no_surface_is_named(bumpy: Mesh, bad: Mesh, side: int) -> None:
    pair = (bad, bumpy) if side == 0 else (bumpy, bad)
    with pytest.raises(MeshError, match="'bad'"):
        match_vertices(*pair, QUICK)
