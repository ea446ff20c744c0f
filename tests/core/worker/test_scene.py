# SPDX-License-Identifier: MIT
"""Requests about a scene that is indexed."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.indexing.reading.answer import MeshPlace
from shapegoogle_core.library.library import Library
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.worker.packed import Packed
from shapegoogle_core.worker.scene import SceneShape, create_library, describe, find_neighbours, store


def waiting(mesh: Mesh, folder: Path, *, is_unsaved: bool = True) -> SceneShape:
    """A shape as the add-on writes it, after something else in the file."""
    arrays = folder / "shapes.bin"
    content = mesh.vertices.astype("<f4").tobytes() + mesh.faces.astype("<i4").tobytes()
    arrays.write_bytes(b"something" + content)
    unmoved = np.eye(4).ravel().tolist()
    record = {
        "name": mesh.name,
        "parts": [{"mesh": 0, "matrix": unmoved}],
        "placements": [{"object": mesh.name, "matrix": unmoved}],
    }
    place = MeshPlace(9, len(mesh.vertices), len(mesh.faces))
    return SceneShape(
        record, (place,), arrays, Path("hall.blend"), up_axis=2, alone=False, is_unsaved=is_unsaved
    )


def test_a_scene_is_described_and_stored_in_place_of_the_one_before(
    path: Path, model: ShapeModel, meshes: list[Mesh]
) -> None:
    model_file = path.with_name("model.npz")
    model.save(model_file)
    create_library(path, str(model_file))
    create_library(path, "no model is loaded for a library that exists")
    packed = [describe(path, waiting(mesh, path.parent)) for mesh in meshes[:2]]
    described = [shape for shape in packed if isinstance(shape, Packed)]
    assert len(described) == 2
    speck = Mesh(np.zeros((4, 3)), name="a speck")
    assert "a speck" in str(describe(path, waiting(speck, path.parent)))
    for shapes in (described, described[:1]):
        store(LibraryAddress(path), "Unsaved file", None, [], shapes)
        assert find_neighbours(path) == len(shapes)
    with Library.open(path, read_only=True) as library:
        (shape,) = library.shapes()
        assert (shape.name, shape.source) == (meshes[0].name, "Unsaved file")


def test_a_shape_is_named_after_the_file_of_its_scene_only_if_that_has_a_name(
    tmp_path: Path, meshes: list[Mesh]
) -> None:
    cube = Mesh(meshes[0].vertices, meshes[0].faces, "Cube")
    assert waiting(cube, tmp_path).read().name == "Cube"
    assert waiting(cube, tmp_path, is_unsaved=False).read().name == "hall (Cube)"


def test_a_root_that_lies_elsewhere_here_is_no_second_root(path: Path, model: ShapeModel) -> None:
    with Library.open(path, model) as library:
        library.add_root(path.parent / "as on the server", "props")
    here = path.parent / "here"
    here.mkdir()
    scene = here / "hall.blend"
    scene.write_bytes(b"a scene")
    store(LibraryAddress(path, (("props", str(here)),)), str(scene), 7, [str(scene)], [])
    with Library.open(path, read_only=True) as library:
        assert [root.name for root in library.roots()] == ["props"]
