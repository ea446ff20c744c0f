# SPDX-License-Identifier: MIT
"""Everything that is accepted as a mesh becomes the same mesh; everything else is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import lapy
import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from shapegoogle_core.errors import MeshError, ShapeGoogleError
from shapegoogle_core.mesh import Mesh, MeshLike, as_mesh, is_mesh_like

TETRAHEDRON: tuple[list[list[int]], list[list[int]]] = (
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
)
VERTICES, FACES = TETRAHEDRON


def same(first: Mesh, second: Mesh) -> bool:
    return np.array_equal(first.vertices, second.vertices) and np.array_equal(first.faces, second.faces)


def test_a_mesh_is_returned_as_it_is() -> None:
    mesh = Mesh(VERTICES, FACES, "own name")
    assert as_mesh(mesh) is mesh
    assert as_mesh(mesh, name="other") is mesh


@pytest.mark.parametrize(
    "shape",
    [
        TETRAHEDRON,
        (np.array(VERTICES), np.array(FACES)),
        (np.array(VERTICES, np.float32), np.array(FACES, np.uint8)),
        (tuple(map(tuple, VERTICES)), tuple(map(tuple, FACES))),
        trimesh.Trimesh(VERTICES, FACES, process=False),
        lapy.TriaMesh(np.array(VERTICES, float), np.array(FACES)),
        SimpleNamespace(vertices=VERTICES, faces=FACES),
        SimpleNamespace(v=VERTICES, t=FACES),
    ],
    ids=["lists", "arrays", "small types", "tuples", "trimesh", "lapy", "vertices faces", "v t"],
)
def test_every_kind_gives_the_same_mesh(shape: MeshLike) -> None:
    mesh = as_mesh(shape, name="tetrahedron")
    assert is_mesh_like(shape)
    assert same(mesh, Mesh(VERTICES, FACES))
    assert mesh.name == "tetrahedron"
    assert type(mesh.vertices) is np.ndarray
    assert type(mesh.faces) is np.ndarray
    assert mesh.vertices.dtype == np.float64
    assert mesh.faces.dtype == np.int32
    assert as_mesh(shape).name == "mesh"


@pytest.mark.parametrize("faces", [None, [], np.empty((0, 3), int)])
def test_without_faces_it_is_a_point_cloud(faces: NDArray[np.int64] | None) -> None:
    for shape in ((VERTICES, faces), SimpleNamespace(vertices=VERTICES, faces=faces)):
        cloud = as_mesh(shape)
        assert is_mesh_like(shape)
        assert cloud.is_point_cloud
        assert np.array_equal(cloud.vertices, VERTICES)


def test_a_change_of_the_source_does_not_change_the_mesh() -> None:
    vertices, faces = np.array(VERTICES, np.float64), np.array(FACES, np.int32)
    mesh = as_mesh((vertices, faces))
    vertices[0], faces[0] = 7, 0
    assert same(mesh, Mesh(VERTICES, FACES))


@pytest.mark.parametrize("sequence", [list, tuple])
def test_a_sequence_of_meshes_is_not_one_mesh(sequence: Callable[..., Any]) -> None:
    mesh = Mesh(VERTICES, FACES)
    every: list[list[object]] = [
        [],
        [mesh],
        [mesh, mesh],
        [TETRAHEDRON],
        [TETRAHEDRON, TETRAHEDRON],
        [TETRAHEDRON, mesh],
        [trimesh.creation.box(), trimesh.creation.box()],
        [(VERTICES, VERTICES), (VERTICES, VERTICES)],
        ["signature", "signature"],
    ]
    for members in every:
        assert not is_mesh_like(sequence(members))
        with pytest.raises(MeshError):
            as_mesh(sequence(members))


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        (None, "'horse' is an object of the type NoneType"),
        (np.array(VERTICES), "'horse' is an object of the type ndarray"),
        ([VERTICES, FACES], "'horse' is an object of the type list"),
        ((VERTICES, FACES, FACES), "'horse' is a tuple of 3 values"),
        ((Mesh(VERTICES), Mesh(VERTICES)), "'horse' is a tuple of 2 values"),
        ("horse.ply", "'horse.ply' is a path.*read_mesh"),
        (Path("horse.ply"), "'horse.ply' is a path.*read_mesh"),
        (([[0, 0], [1, 0]], [[0, 1, 1]]), r"'horse': vertices must have shape \(n, 3\)"),
        (([[0, 0, 0], [1, 0]], [[0, 1, 1]]), "'horse': vertices and faces must be arrays of numbers"),
        ((VERTICES, [[0, 1, 2, 3]]), r"'horse': faces must be triangles"),
        ((VERTICES, [[0, 1, 9]]), "'horse': a face names vertex 9"),
        (SimpleNamespace(v=VERTICES, t=[[0, 1, 2, 3]]), "'horse': faces must be triangles"),
    ],
)
def test_everything_else_is_refused(shape: MeshLike, words: str) -> None:
    with pytest.raises(MeshError, match=words):
        as_mesh(shape, name="horse")


def test_refusal_says_what_is_accepted() -> None:
    with pytest.raises(MeshError, match=r"give a Mesh, a tuple \(vertices, faces\), or an object with"):
        as_mesh(7)  # type: ignore[arg-type]


def test_mesh_errors_are_value_errors() -> None:
    assert issubclass(MeshError, ShapeGoogleError)
    with pytest.raises(ValueError, match="vertices must have shape"):
        Mesh([1.0, 2.0])


@st.composite
def tables(draw: st.DrawFn) -> tuple[list[list[float]], list[list[int]]]:
    """Vertices and faces as nested lists."""
    number = st.floats(allow_nan=False, allow_infinity=False)
    vertices = draw(st.lists(st.lists(number, min_size=3, max_size=3), min_size=1, max_size=20))
    corner = st.integers(0, len(vertices) - 1)
    return vertices, draw(st.lists(st.lists(corner, min_size=3, max_size=3), max_size=20))


@given(tables())
def test_round_trips(shape: tuple[list[list[float]], list[list[int]]]) -> None:
    """From lists to a mesh, to a tuple, to another library's mesh and back, nothing changes."""
    mesh = as_mesh(shape)
    assert mesh.vertices.tolist() == shape[0]
    assert mesh.faces.tolist() == shape[1]
    for other in (
        (mesh.vertices, mesh.faces),
        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False, validate=False),
        SimpleNamespace(v=mesh.vertices, t=mesh.faces),
    ):
        assert is_mesh_like(other)
        assert same(as_mesh(other), mesh)
