# SPDX-License-Identifier: MIT
"""The operations of every store: records with extents and tags, filters, codes and bags."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.address import as_place
from shapegoogle_core.library.storage.opening import open_store
from shapegoogle_core.library.storage.records import NewShape, SourceKey, SourceRecord, StoreSummary
from shapegoogle_core.library.storage.signatures import round_bags
from shapegoogle_core.library.storage.store import Store, all_codes
from shapegoogle_core.mesh import Mesh
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
def store(place: str, model: ShapeModel) -> Iterator[Store]:
    """An empty store of each kind."""
    opened, _ = open_store(as_place(place), model, read_only=False, timeout=5)
    with closing(opened):
        yield opened


@pytest.fixture
def filled(store: Store, make_signature: SignatureMaker) -> Store:
    for seed, (name, source, faces, extents, tags) in enumerate(SHAPES):
        signature = replace(make_signature(seed), face_count=faces, extents=extents)
        store.add(SourceKey("", source), NewShape(signature, name, tags=tags))
    return store


def found(store: Store, where: Filter) -> list[str]:
    shape_ids = store.filtered_ids(where)
    assert shape_ids.dtype == np.int64
    assert np.all(np.diff(shape_ids) > 0)
    return [record.name for record in store.shapes(shape_ids.tolist())]


def test_extents_and_tags_come_back(filled: Store) -> None:
    for records in (filled.shapes([1, 2, 3, 4, 5, 6]), filled.shapes_after(0, 10)):
        assert [record.extents for record in records] == [shape[3] for shape in SHAPES]
        assert [record.tags for record in records] == [tuple(sorted(shape[4])) for shape in SHAPES]


def test_a_tag_counts_once_and_goes_with_its_shape(filled: Store, make_signature: SignatureMaker) -> None:
    shape_id = filled.add(None, NewShape(make_signature(9), "twice", tags=("new", "new", "a")))
    assert filled.shapes([shape_id])[0].tags == ("a", "new")
    assert filled.filtered_ids(Filter(tag="new")).tolist() == [shape_id]
    filled.remove_shapes([shape_id])
    assert filled.filtered_ids(Filter(tag="new")).tolist() == []


def test_a_mesh_brings_its_extents(place: str, model: ShapeModel, bumpy: Mesh) -> None:
    with Library.open(place, model) as library:
        shape_id = library.add(bumpy, tags=["rock"])
        (record,) = library.shapes()
        assert record.extents == tuple(np.ptp(bumpy.vertices, axis=0))
        assert record.tags == ("rock",)
        assert library.signature(shape_id).extents == record.extents


def test_an_empty_store(store: Store, place: str, model: ShapeModel) -> None:
    assert (store.count(), store.sources(), store.shapes_after(0, 10)) == (0, [], [])
    assert store.filtered_ids(Filter(name="a")).tolist() == []
    assert store.bags_after(0, 10, model.bag_size)[0] == []
    assert all_codes(store, "codes", 9)[1].shape == (0, 9)
    assert store.model() == (model.identifier, model.to_bytes())
    assert store.name in (place, place.replace("///", "//"))
    assert not store.read_only


def test_sources_and_numbers(store: Store, make_signature: SignatureMaker) -> None:
    store.replace_source(SourceRecord("b", 5, 6, "ab", None, 0), [NewShape(make_signature(1), "one")])
    store.replace_source(SourceRecord("a", 1, 2, None, "no faces", 0), [])
    assert store.sources() == [
        SourceRecord("a", 1, 2, None, "no faces", 0),
        SourceRecord("b", 5, 6, "ab", None, 1),
    ]
    summary = store.summary()
    assert summary == StoreSummary(shapes=1, sources=2, failed=1, bytes=summary.bytes, format=8)
    assert store.update_source(SourceKey("", "b"), 7, 8)
    assert not store.update_source(SourceKey("", "c"), 7, 8)
    assert store.sources()[1] == SourceRecord("b", 7, 8, "ab", None, 1)
    assert store.remove_sources([SourceKey("", name) for name in "abc"]) == 2
    assert (store.count(), store.sources()) == (0, [])


def test_signatures_come_back_in_the_order_of_ids(
    filled: Store, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    asked = [5, 99, 2, 3]
    ids, bags = filled.bags(asked, model.bag_size)
    assert ids == [2, 3, 5]
    np.testing.assert_array_equal(bags, [round_bags(make_signature(i - 1).bags) for i in ids])
    code_ids, codes = filled.codes("codes", asked, 9)
    assert code_ids.tolist() == [2, 3, 5]
    np.testing.assert_array_equal(codes, [make_signature(i - 1).code for i in ids])
    assert filled.bags_after(2, 2, model.bag_size)[0] == [3, 4]
    assert [record.shape_id for record in filled.shapes(asked)] == [2, 3, 5]
    assert [record.shape_id for record in filled.shapes_after(4, 9)] == [5, 6]


def test_local_words_samples_and_thumbnails_are_optional(
    store: Store, make_signature: SignatureMaker
) -> None:
    local = np.arange(4, dtype=np.uint8)
    with_all = replace(make_signature(1), local_code=local)
    store.add(None, NewShape(make_signature(0), "without"))
    store.add(None, NewShape(with_all, "with", thumbnail=b"png"))
    ids, codes = all_codes(store, "local_words", 4)
    assert (ids.tolist(), codes.tolist()) == ([2], [local.tolist()])
    assert (store.thumbnail(1), store.thumbnail(2), store.thumbnail(3)) == (None, b"png", None)
    assert store.samples([1, 2, 3]) == {}


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
def test_names(filled: Store, name: str, names: list[str]) -> None:
    assert found(filled, Filter(name=name)) == names


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
def test_folders(filled: Store, folder: str, names: list[str]) -> None:
    assert found(filled, Filter(folder=folder)) == names


def test_a_relative_folder(
    filled: Store, make_signature: SignatureMaker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    source = SourceRecord(str(tmp_path / "meshes" / "horse.obj"), 1, 1, None, None, 1)
    filled.replace_source(source, [NewShape(make_signature(1), "horse")])
    assert found(filled, Filter(folder="meshes")) == ["horse"]
    assert found(filled, Filter(folder="./meshes/../meshes")) == ["horse"]
    assert found(filled, Filter(folder="mesh")) == []


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
def test_tags_faces_sizes_and_all_together(filled: Store, where: Filter, names: list[str]) -> None:
    assert found(filled, where) == names
