# SPDX-License-Identifier: MIT
"""Requests about a scene that is indexed."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shapegoogle_core.client import LibraryAddress
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.worker.packed import Packed
from shapegoogle_core.worker.scene import create_library, describe, find_neighbours, store


def test_a_scene_is_described_and_stored_in_place_of_the_one_before(
    path: Path, model: ShapeModel, meshes: list[Mesh]
) -> None:
    model_file = path.with_name("model.npz")
    model.save(model_file)
    create_library(path, str(model_file))
    create_library(path, "no model is loaded for a library that exists")
    packed = [describe(path, NewShape(mesh, mesh.name)) for mesh in meshes[:2]]
    described = [shape for shape in packed if isinstance(shape, Packed)]
    assert len(described) == 2
    speck = Mesh(np.zeros((4, 3)), name="a speck")
    assert "a speck" in str(describe(path, NewShape(speck, "a speck")))
    for shapes in (described, described[:1]):
        store(LibraryAddress(path), "Unsaved file", None, [], shapes)
        assert find_neighbours(path) == len(shapes)
    with Library.open(path, read_only=True) as library:
        (shape,) = library.shapes()
        assert (shape.name, shape.source) == (meshes[0].name, "Unsaved file")


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
