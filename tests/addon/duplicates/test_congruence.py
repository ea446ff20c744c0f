# SPDX-License-Identifier: MIT
"""Congruence finds motions and scales, also behind another order; it refuses mirror images and changes."""

from __future__ import annotations

import importlib
import threading
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.addon.conftest import addon_name

_module = importlib.import_module(f"{addon_name()}.duplicates.congruence")
TOLERANCE, PolygonMesh, congruence = _module.TOLERANCE, _module.PolygonMesh, _module.congruence


def test_rows_are_made_unique_as_numpy_does() -> None:
    random = np.random.default_rng(0)
    rows = random.integers(-2, 3, (200, 3)) * 0.5
    expected, which = np.unique(rows, axis=0, return_inverse=True)
    found, found_which = _module._unique_rows(rows)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(found_which, which.ravel())


def polygons(vertices: Any, faces: Any) -> Any:
    """A mesh of triangles or quads, in single precision as Blender keeps it."""
    faces = np.asarray(faces, np.int64)
    edges = np.concatenate([faces, np.roll(faces, -1, axis=1)], axis=None).reshape(2, -1).T
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    vertices = np.asarray(vertices, np.float32).astype(np.float64)
    return PolygonMesh(vertices, faces.ravel(), np.full(len(faces), faces.shape[1]), edges)


def faces_of(mesh: Any) -> Any:
    return mesh.corners.reshape(len(mesh.sizes), -1)


def moved(mesh: Any, seed: Any = 0, scale: Any = 1.0, mirror: Any = False) -> Any:
    random = np.random.default_rng(seed)
    rotation = Rotation.random(random_state=seed).as_matrix() @ np.diag([-1 if mirror else 1, 1, 1])
    return polygons(scale * mesh.vertices @ rotation.T + random.uniform(-5, 5, 3), faces_of(mesh))


def shuffled(mesh: Any, seed: Any = 0) -> Any:
    """Another order of vertices, edges and polygons, and of the corners where polygons begin."""
    random = np.random.default_rng(seed)
    order = random.permutation(len(mesh.vertices))
    faces = np.argsort(order)[faces_of(mesh)][random.permutation(len(mesh.sizes))]
    faces = np.stack([np.roll(face, random.integers(len(face))) for face in faces])
    return polygons(mesh.vertices[order], faces)


def lump(seed: Any = 0) -> Any:
    random = np.random.default_rng(seed)
    sphere = trimesh.creation.icosphere(2)
    return polygons(sphere.vertices * (1 + 0.3 * random.random((len(sphere.vertices), 1))), sphere.faces)


CUBE = polygons(
    [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
)


def symmetric_shapes() -> Any:
    cylinder = trimesh.creation.cylinder(1.0, 3.0, sections=48)
    torus = trimesh.creation.torus(2.0, 0.5, major_sections=40, minor_sections=12)
    box = trimesh.creation.box((1, 2, 3))
    sphere = trimesh.creation.icosphere(3)
    uv_sphere = trimesh.creation.uv_sphere(1.0, count=[16, 32])
    shapes = {"cylinder": cylinder, "torus": torus, "box": box, "icosphere": sphere, "uv sphere": uv_sphere}
    return {"cube": CUBE} | {name: polygons(mesh.vertices, mesh.faces) for name, mesh in shapes.items()}


def check_carries(found: Any, first: Any, second: Any) -> None:
    placed = first.vertices @ found.matrix[:3, :3].T + found.matrix[:3, 3]
    off = np.abs(placed - second.vertices[found.vertex_order]).max()
    assert off <= TOLERANCE * second.size
    assert np.linalg.det(found.matrix[:3, :3]) == pytest.approx(found.scale**3, rel=1e-6)
    np.testing.assert_array_equal(found.vertex_order[first.corners], second.corners[found.corner_order])
    np.testing.assert_array_equal(
        np.sort(found.vertex_order[first.edges], axis=1), second.edges[found.edge_order]
    )
    owner = np.repeat(np.arange(len(second.sizes)), second.sizes)
    np.testing.assert_array_equal(owner[found.corner_order], np.repeat(found.polygon_order, first.sizes))
    for order in (found.vertex_order, found.corner_order, found.polygon_order, found.edge_order):
        np.testing.assert_array_equal(np.sort(order), np.arange(len(order)))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000), scale=st.floats(0.01, 100), shuffle=st.booleans())
def test_any_motion_and_scale_is_found(seed: Any, scale: Any, shuffle: Any) -> None:
    first = lump(seed)
    second = moved(first, seed, scale)
    if shuffle:
        second = shuffled(second, seed)
    found = congruence(first, second)
    assert found is not None
    assert found.scale == pytest.approx(scale, rel=1e-5)
    assert found.same_order is not shuffle
    check_carries(found, first, second)


@pytest.mark.parametrize("name", list(symmetric_shapes()))
@pytest.mark.parametrize("seed", [1, 2])
def test_symmetric_shapes_in_another_order(name: str, seed: Any) -> None:
    first = symmetric_shapes()[name]
    second = shuffled(moved(first, seed, 2.54), seed)
    found = congruence(first, second)
    assert found is not None, name
    check_carries(found, first, second)


def test_mirror_images_are_not_congruent() -> None:
    first = lump()
    mirrored = moved(first, mirror=True)
    assert congruence(first, mirrored) is None
    inside_out = polygons(mirrored.vertices, faces_of(mirrored)[:, ::-1])
    assert congruence(first, inside_out) is None
    assert congruence(first, shuffled(inside_out)) is None


def test_a_symmetric_shape_is_its_own_mirror_image() -> None:
    mirrored = moved(CUBE, mirror=True)
    found = congruence(CUBE, polygons(mirrored.vertices, faces_of(mirrored)[:, ::-1]))
    assert found is not None
    check_carries(found, CUBE, polygons(mirrored.vertices, faces_of(mirrored)[:, ::-1]))


@pytest.mark.parametrize(("step", "same"), [(0.5, True), (4.0, False)])
@pytest.mark.parametrize("shuffle", [False, True])
def test_one_moved_vertex_counts_from_the_tolerance_on(step: Any, same: Any, shuffle: Any) -> None:
    first = lump()
    vertices = first.vertices.copy()
    vertices[7] += step * TOLERANCE * first.size * np.array([0, 0.6, 0.8])
    second = polygons(vertices, faces_of(first))
    second = shuffled(second) if shuffle else second
    assert (congruence(first, second) is not None) is same


def test_other_connectivity_is_another_mesh() -> None:
    """The same points, but one square cut along the other diagonal."""
    square = [[0, 0, 0], [1, 0, 0], [1.1, 1, 0], [0, 1.3, 0.4]]
    first = polygons(square, [[0, 1, 2], [0, 2, 3]])
    second = polygons(square, [[0, 1, 3], [1, 2, 3]])
    assert congruence(first, second) is None
    stretched = polygons(first.vertices * [1, 1, 1.2], faces_of(first))
    assert congruence(first, stretched) is None


def test_split_vertices_keep_their_order_apart() -> None:
    """Vertices that coincide, as at the seams of an imported mesh."""
    sphere = lump()
    faces = faces_of(sphere)
    first = polygons(sphere.vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3))
    second = shuffled(moved(first, 3), 3)
    found = congruence(first, second)
    assert found is not None
    check_carries(found, first, second)


def test_without_extent_or_faces() -> None:
    point = PolygonMesh(np.zeros((3, 3)), np.empty(0, int), np.empty(0, int), np.empty((0, 2), int))
    assert congruence(point, point) is None
    empty = PolygonMesh(np.empty((0, 3)), np.empty(0, int), np.empty(0, int), np.empty((0, 2), int))
    assert congruence(empty, empty) is None
    line = PolygonMesh(
        np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]]),
        np.empty(0, int),
        np.empty(0, int),
        np.array([[0, 1], [1, 2]]),
    )
    found = congruence(line, PolygonMesh(line.vertices[:, ::-1] + 2, line.corners, line.sizes, line.edges))
    assert found is not None
    check_carries(found, line, PolygonMesh(line.vertices[:, ::-1] + 2, line.corners, line.sizes, line.edges))


def test_a_large_mesh_behind_another_order() -> None:
    sphere = trimesh.creation.icosphere(6)  # 40,962 vertices
    random = np.random.default_rng(0)
    first = polygons(sphere.vertices * (1 + 0.1 * random.random((len(sphere.vertices), 1))), sphere.faces)
    second = shuffled(moved(first))
    assert congruence(first, second) is not None


def test_large_meshes_are_compared_in_another_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = CUBE, shuffled(moved(CUBE, seed=3))
    steps = _module.congruence_steps(first, second)
    with pytest.raises(StopIteration) as end:
        next(steps)
    expected = end.value.value
    threads = []

    def compare(one: Any, two: Any) -> Any:
        threads.append(threading.current_thread())
        return congruence(one, two)

    monkeypatch.setattr(_module, "congruence", compare)
    monkeypatch.setattr(_module, "LARGE", 1)
    found = importlib.import_module(f"{addon_name()}.time_slices").result_of(
        _module.congruence_steps(first, second)
    )
    np.testing.assert_array_equal(found.vertex_order, expected.vertex_order)
    assert len(threads) == 1
    assert threads[0] is not threading.current_thread()
