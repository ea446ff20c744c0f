# SPDX-License-Identifier: MIT
"""Adding, replacing, removing and listing; what a library gives back."""

from __future__ import annotations

import os
import sqlite3
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.address import is_database
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature

PNG = b"\x89PNG\r\n\x1a\n made up"


def names(library: Library) -> list[str]:
    return [shape.name for shape in library.shapes()]


def test_a_new_library_is_empty_and_knows_its_model(path: Path, model: ShapeModel) -> None:
    with Library.open(path, model) as library:
        assert len(library) == 0
        assert library.model is model
        assert list(library.shapes()) == []
        assert library.sources() == {}
    with Library.open(path) as library:
        assert library.model.identifier == model.identifier
        assert library.info() == {
            "path": str(path),
            "shapes": 0,
            "sources": 0,
            "failed": 0,
            "model": model.identifier,
            "model_name": "tiny",
            "code_bits": 72,
            "bag_size": model.bag_size,
            "bytes": path.stat().st_size,
            "schema": 8,
            "without_views": 0,
            "roots": [],
        }


def test_it_is_one_file(path: Path, model: ShapeModel, make_signature: Callable[..., ShapeSignature]) -> None:
    with Library.open(path, model) as library:
        library.add_signature(make_signature(1), "one")
        assert [entry.name for entry in path.parent.iterdir()] == [path.name]


def test_add_describes_the_mesh_and_remembers_what_it_was(
    place: str, model: ShapeModel, meshes: list[Mesh]
) -> None:
    with Library.open(place, model) as library:
        shape_id = library.add(
            meshes[0], name="horse", source="animals.blend", object_name="Horse", thumbnail=PNG
        )
        (shape,) = library.shapes()
        assert (shape.shape_id, shape.name, shape.source, shape.object_name) == (
            shape_id,
            "horse",
            "animals.blend",
            "Horse",
        )
        assert (shape.vertex_count, shape.face_count) == (len(meshes[0].vertices), len(meshes[0].faces))
        assert shape.area == meshes[0].area
        assert library.thumbnail(shape_id) == PNG


def test_a_shape_without_a_name_takes_that_of_its_source_or_mesh(
    place: str, model: ShapeModel, meshes: list[Mesh]
) -> None:
    mesh = meshes[0]
    with Library.open(place, model) as library:
        library.add(mesh)
        library.add(mesh, source="models/horse.ply")
        library.add(mesh, source=Path("models") / "cow.ply", name="cow")
        library.add((mesh.vertices, mesh.faces))
        assert names(library) == [mesh.name, "horse.ply", "cow", "mesh"]
        assert {shape.source for shape in library.shapes()} == {
            "",
            "models/horse.ply",
            str(Path("models") / "cow.ply"),
        }


def test_signature_round_trip(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    signature = make_signature(3)
    with Library.open(place, model) as library:
        shape_id = library.add_signature(signature, "one")
    with Library.open(place) as library:
        back = library.signature(shape_id)
        np.testing.assert_array_equal(back.bags, signature.bags.astype(np.float16))
        np.testing.assert_allclose(back.bags, signature.bags, rtol=2.0**-11, atol=2.0**-25)
        np.testing.assert_array_equal(back.code, signature.code)
        assert (back.area, back.vertex_count, back.face_count) == (
            signature.area,
            signature.vertex_count,
            signature.face_count,
        )
        again = library.signature(library.add_signature(back, "again"))
        np.testing.assert_array_equal(again.bags, back.bags)


def test_numpy_counts_are_taken_as_they_are(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    signature = make_signature(3)
    counts: tuple[Any, Any, Any] = (np.float32(2), np.int64(7), np.int32(9))
    odd = type(signature)(signature.bags, signature.code, *counts)
    with Library.open(place, model) as library:
        back = library.signature(library.add_signature(odd, "one"))
        assert (back.area, back.vertex_count, back.face_count) == (2.0, 7, 9)


def test_adding_again_within_a_source_replaces(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    with Library.open(place, model) as library:
        first = library.add_signature(make_signature(1), "horse", source="a.blend", thumbnail=PNG)
        library.add_signature(make_signature(2), "cow", source="a.blend")
        library.add_signature(make_signature(3), "horse", source="b.blend")
        library.add_signature(make_signature(4), "horse", source="a.blend", object_name="Horse.001")
        second = library.add_signature(make_signature(5), "horse", source="a.blend")
        assert sorted(names(library)) == ["cow", "horse", "horse", "horse"]
        np.testing.assert_array_equal(library.signature(second).code, make_signature(5).code)
        assert library.thumbnail(second) is None
        with pytest.raises(LibraryError, match=f"no shape {first}"):
            library.signature(first)


def test_adding_without_a_source_always_adds(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    with Library.open(place, model) as library:
        ids = {library.add_signature(make_signature(1), "horse") for _ in range(3)}
        assert len(ids) == len(library) == 3


def test_ids_are_never_given_twice(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    with Library.open(place, model) as library:
        first = library.add_signature(make_signature(1), "horse")
        assert library.remove_shape(first)
        assert not library.remove_shape(first)
        assert library.add_signature(make_signature(2), "cow") > first


def test_replace_source_swaps_all_shapes_of_a_file(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    with Library.open(place, model) as library:
        library.add_signature(make_signature(0), "keep", source="other.obj")
        library.replace_source(
            "a.blend",
            size=10,
            mtime_ns=20,
            sha256="ab",
            shapes=[NewShape(make_signature(i), f"old {i}", f"Object.{i}", PNG) for i in range(4)],
        )
        ids = library.replace_source(
            "a.blend",
            size=11,
            mtime_ns=21,
            sha256="cd",
            shapes=[NewShape(make_signature(i), f"new {i}", f"Object.{i}") for i in range(2)],
        )
        assert names(library) == ["keep", "new 0", "new 1"]
        assert [shape.shape_id for shape in library.shapes()][1:] == ids
        source = library.sources()["a.blend"]
        assert (source.size, source.mtime_ns, source.sha256, source.error, source.shape_count) == (
            11,
            21,
            "cd",
            None,
            2,
        )
        assert [library.thumbnail(shape_id) for shape_id in ids] == [None, None]
        assert len(library) == 3
    if not is_database(place):  # nothing of the old shapes is left in any table
        connection = sqlite3.connect(place)
        for table in ("shapes", "codes", "bags"):
            assert connection.execute(f"SELECT count(*) FROM {table}").fetchone() == (3,)
        assert connection.execute("SELECT count(*) FROM thumbnails").fetchone() == (0,)
        connection.close()


def test_failed_files_are_remembered(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    with Library.open(place, model) as library:
        library.replace_source("a.obj", size=1, mtime_ns=2, sha256="ab", error="'a.obj' has no faces")
        library.replace_source(
            "b.obj", size=1, mtime_ns=2, sha256=None, shapes=[NewShape(make_signature(1), "b")]
        )
        library.replace_source("c.blend", size=1, mtime_ns=2, sha256="ee")
    with Library.open(place, read_only=True) as library:
        assert {name: source.error for name, source in library.sources().items()} == {
            "a.obj": "'a.obj' has no faces",
            "b.obj": None,
            "c.blend": None,
        }
        info = library.info()
        assert (info["shapes"], info["sources"], info["failed"]) == (1, 3, 1)


def test_a_file_that_was_only_touched_gets_its_new_time(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    with Library.open(place, model) as library:
        library.replace_source(
            "b.obj", size=1, mtime_ns=2, sha256="ab", shapes=[NewShape(make_signature(1), "b")]
        )
        assert library.update_source("b.obj", size=3, mtime_ns=4)
        assert not library.update_source("unknown.obj", size=3, mtime_ns=4)
        source = library.sources()["b.obj"]
        assert (source.size, source.mtime_ns, source.sha256, source.shape_count) == (3, 4, "ab", 1)


def test_remove_takes_all_of_a_source(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature]
) -> None:
    with Library.open(place, model) as library:
        for seed, source in enumerate(["a.obj", "a.obj", "b.obj"]):
            library.add_signature(make_signature(seed), f"shape {seed}", source=source)
        assert library.remove("a.obj")
        assert not library.remove("a.obj")
        assert names(library) == ["shape 2"]
        assert list(library.sources()) == ["b.obj"]


def test_remove_missing_takes_only_indexed_files_that_are_gone(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature], tmp_path: Path
) -> None:
    folder, elsewhere = tmp_path / "meshes", tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "there.obj").touch()
    with Library.open(place, model) as library:
        for file in (folder / "there.obj", folder / "gone.obj", elsewhere / "gone.obj"):
            library.replace_source(
                file, size=1, mtime_ns=1, sha256="ab", shapes=[NewShape(make_signature(1), file.name)]
            )
        label = str(folder / "a label, not a file")
        library.add_signature(make_signature(2), "labelled", source=label)
        with pytest.raises(LibraryError, match="elsewhere' does not exist"):
            library.remove_missing([folder, elsewhere])
        assert len(library) == 4
        assert library.remove_missing([folder]) == [str(folder / "gone.obj")]
        assert library.remove_missing([folder]) == []
        assert set(library.sources()) == {str(folder / "there.obj"), str(elsewhere / "gone.obj"), label}


def test_a_long_listing_comes_complete_while_the_library_changes(
    place: str,
    model: ShapeModel,
    make_signature: Callable[..., ShapeSignature],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("shapegoogle_core.library.parts.listing.PAGE", 2)
    with Library.open(place, model) as library:
        for seed in range(7):
            library.add_signature(make_signature(seed), f"shape {seed}")
        listing = library.shapes()
        first = next(listing)
        library.remove_shape(first.shape_id)
        assert [shape.name for shape in listing] == [f"shape {seed}" for seed in range(1, 7)]


@pytest.mark.parametrize("name", ["Stra\udcdfe.obj", "half \ud83d a face.obj", "Größe 100% #1?.obj"])
def test_file_names_that_are_no_unicode(
    place: str, model: ShapeModel, make_signature: Callable[..., ShapeSignature], name: str
) -> None:
    with Library.open(place, model) as library:
        library.replace_source(
            name,
            size=1,
            mtime_ns=1,
            sha256="ab",
            shapes=[NewShape(make_signature(1), name, name)],
            error=name,
        )
        library.add_signature(make_signature(1), name, source=name, object_name=name)
        (shape,) = library.shapes()
        assert (shape.name, shape.source, shape.object_name) == (name, name, name)
        assert library.sources()[name].error == name
        assert library.remove(name)


@pytest.mark.skipif(sys.platform != "linux", reason="only there names are any bytes")
def test_a_library_whose_own_name_is_no_unicode(tmp_path: Path, model: ShapeModel) -> None:
    path = tmp_path / os.fsdecode(b"b\xfccher #1?.sglib")
    with Library.open(path, model):
        assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_a_relative_path_and_a_string_will_do(
    tmp_path: Path, model: ShapeModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with Library.open("shapes 100%.sglib", model):
        assert (tmp_path / "shapes 100%.sglib").exists()
