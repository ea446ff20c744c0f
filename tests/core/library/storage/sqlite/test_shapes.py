# SPDX-License-Identifier: MIT
"""Records with extents and tags, and the filters on them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.library import Filter, Library, NewShape, SourceRecord
from shapegoogle_core.library.storage.sqlite.store import SqliteStore
from shapegoogle_core.model import ShapeModel, ShapeSignature

SignatureMaker = Callable[..., ShapeSignature]

# Name, source, faces, extents, tags.
SHAPES: list[tuple[str, str, int, tuple[float, float, float], tuple[str, ...]]] = [
    ("Chair", "/assets/furniture/chairs.blend", 100, (1.0, 0.5, 0.25), ("wood", "seat")),
    ("armchair.001", "/assets/furniture/chairs.blend", 2_000, (0.5, 3.0, 1.0), ("seat",)),
    ("100%_oak", "/assets/furniture2/oak.obj", 0, (0.0, 0.0, 0.0), ()),
    ("STUHL groß", "C:\\assets\\Möbel\\stuhl.obj", 500, (20.0, 20.0, 40.0), ("Seat", "it's")),
    ("[a]?", "", 7, (1.0, 1.0, 1.0), ()),
    ("half \ud83d a face", "Stra\udcdfe/x.obj", 8, (2.0, 2.0, 2.0), ("\udcdf",)),
]


@pytest.fixture
def store(path: Path, model: ShapeModel, make_signature: SignatureMaker) -> Iterator[SqliteStore]:
    Library.open(path, model).close()
    with closing(SqliteStore(path, create=False, read_only=False, timeout=5)) as opened:
        for seed, (name, source, faces, extents, tags) in enumerate(SHAPES):
            signature = replace(make_signature(seed), face_count=faces, extents=extents)
            opened.add(source, NewShape(signature, name, tags=tags))
        yield opened


def found(store: SqliteStore, where: Filter) -> list[str]:
    shape_ids = store.filtered_ids(where)
    assert shape_ids.dtype == np.int64
    assert np.all(np.diff(shape_ids) > 0)
    return [record.name for record in store.shapes(shape_ids.tolist())]


def test_extents_and_tags_come_back(store: SqliteStore) -> None:
    for records in (store.shapes([1, 2, 3, 4, 5, 6]), store.shapes_after(0, 10)):
        assert [record.extents for record in records] == [shape[3] for shape in SHAPES]
        assert [record.tags for record in records] == [tuple(sorted(shape[4])) for shape in SHAPES]


def test_a_tag_counts_once_and_goes_with_its_shape(
    store: SqliteStore, make_signature: SignatureMaker
) -> None:
    shape_id = store.add("", NewShape(make_signature(9), "twice", tags=("new", "new", "a")))
    assert store.shapes([shape_id])[0].tags == ("a", "new")
    store.remove_shapes([shape_id])
    assert store.value("SELECT count(*) FROM tags WHERE tag = 'new'") == 0


def test_a_mesh_brings_its_extents(path: Path, model: ShapeModel, shapes: type) -> None:
    mesh = shapes.bumpy(2, seed=0)  # type: ignore[attr-defined]
    with Library.open(path, model) as library:
        shape_id = library.add(mesh, tags=["rock"])
        (record,) = library.shapes()
        assert record.extents == tuple(np.ptp(mesh.vertices, axis=0))
        assert record.tags == ("rock",)
        assert library.signature(shape_id).extents == record.extents


@pytest.mark.parametrize(
    ("name", "names"),
    [
        ("chair", ["Chair", "armchair.001"]),
        ("CHAIR", ["Chair", "armchair.001"]),
        ("chair*", ["Chair"]),
        ("?rmchair*1", ["armchair.001"]),
        ("cha?r", ["Chair"]),
        ("groß", ["STUHL groß"]),
        ("*GROẞ", ["STUHL groß"]),
        ("stuhl GRO?*", ["STUHL groß"]),
        ("%", ["100%_oak"]),
        ("_", ["100%_oak"]),
        ("\\", []),
        ("[a]*", ["[a]?"]),
        ("\ud83d", ["half \ud83d a face"]),
        ("'; DROP TABLE shapes; --", []),
    ],
)
def test_names(store: SqliteStore, name: str, names: list[str]) -> None:
    assert found(store, Filter(name=name)) == names


@pytest.mark.parametrize(
    ("folder", "names"),
    [
        ("/assets/furniture", ["Chair", "armchair.001"]),
        ("/assets/furniture/", ["Chair", "armchair.001"]),
        ("/assets", ["Chair", "armchair.001", "100%_oak"]),
        ("/", ["Chair", "armchair.001", "100%_oak"]),
        ("/ASSETS", []),
        ("C:\\assets", ["STUHL groß"]),
        ("C:\\assets\\Möbel\\", ["STUHL groß"]),
        ("/assets/%", []),
        ("Stra\udcdfe", ["half \ud83d a face"]),
    ],
)
def test_folders(store: SqliteStore, folder: str, names: list[str]) -> None:
    assert found(store, Filter(folder=folder)) == names


def test_a_relative_folder(
    store: SqliteStore, make_signature: SignatureMaker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    source = SourceRecord(str(tmp_path / "meshes" / "horse.obj"), 1, 1, None, None, 1)
    store.replace_source(source, [NewShape(make_signature(1), "horse")])
    assert found(store, Filter(folder="meshes")) == ["horse"]
    assert found(store, Filter(folder="./meshes/../meshes")) == ["horse"]
    assert found(store, Filter(folder="mesh")) == []


@pytest.mark.parametrize(
    ("where", "names"),
    [
        (Filter(tag="seat"), ["Chair", "armchair.001"]),
        (Filter(tag="Seat"), ["STUHL groß"]),
        (Filter(tag="it's"), ["STUHL groß"]),
        (Filter(tag="sea"), []),
        (Filter(tag="\udcdf"), ["half \ud83d a face"]),
        (Filter(faces=(100, 500)), ["Chair", "STUHL groß"]),
        (Filter(faces=(None, 0)), ["100%_oak"]),
        (Filter(faces=(501, None)), ["armchair.001"]),
        (Filter(size=(3.0, 3.0)), ["armchair.001"]),
        (Filter(size=(10, None)), ["STUHL groß"]),
        (Filter(size=(None, 1)), ["Chair", "100%_oak", "[a]?"]),
        (Filter(name="chair", folder="/assets", tag="seat", faces=(1, 100), size=(0, 2)), ["Chair"]),
        (Filter(name="chair", tag="wood", faces=(2_000, 2_000)), []),
        (Filter(kind="moved", min_similarity=0.5), [shape[0] for shape in SHAPES]),
    ],
)
def test_tags_faces_sizes_and_all_together(store: SqliteStore, where: Filter, names: list[str]) -> None:
    assert found(store, where) == names
