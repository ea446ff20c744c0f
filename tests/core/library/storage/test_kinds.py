# SPDX-License-Identifier: MIT
"""Views and neighbours in a library, and libraries from before they existed."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.address import as_place
from shapegoogle_core.library.storage.opening import open_store
from shapegoogle_core.library.storage.records import NewShape, SourceKey
from shapegoogle_core.library.storage.signatures import stored_views
from shapegoogle_core.library.storage.sqlite.store import SqliteStore
from shapegoogle_core.library.storage.store import Store, all_codes
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel, ShapeSignature
from shapegoogle_core.views import CODE_BYTES, ViewModel

SignatureMaker = Callable[..., ShapeSignature]


@pytest.fixture
def seeing_model(model: ShapeModel, view_model: ViewModel) -> ShapeModel:
    return model.with_parts(views=view_model)


def downgrade(path: Path, model: ShapeModel) -> None:
    """Turn a library into one of format 7, with the model that it had."""
    tables = ("views", "view_codes", "view_code_blocks", "neighbours")
    with closing(sqlite3.connect(path)) as connection, connection:
        for table in tables:
            connection.execute(f"DROP TABLE {table}")
        connection.execute("UPDATE meta SET value = '7' WHERE key = 'schema'")
        connection.execute("UPDATE model SET content = ?", (model.to_bytes(),))


def opened(path: Path) -> closing[SqliteStore]:
    return closing(SqliteStore(path, create=False, read_only=False, timeout=5))


def opened_store(place: str, model: ShapeModel) -> closing[Store]:
    return closing(open_store(as_place(place), model, read_only=False, timeout=5)[0])


def test_views_come_back(place: str, seeing_model: ShapeModel, meshes: list[Mesh]) -> None:
    signatures = [seeing_model.describe(mesh) for mesh in meshes]
    with Library.open(place, seeing_model) as library:
        for signature in signatures:
            library.add_signature(signature, "shape")
        again = library.signature(2)
        assert library.info()["without_views"] == 0
        assert library.reindexing_advice() == ""
    assert again.views is not None
    assert again.view_code is not None
    assert again.views.made_by == signatures[1].views.made_by  # type: ignore[union-attr]
    np.testing.assert_array_equal(again.views.descriptors, signatures[1].views.descriptors)  # type: ignore[union-attr]
    assert again.view_code.tolist() == signatures[1].view_code.tolist()  # type: ignore[union-attr]
    with opened_store(place, seeing_model) as store:
        ids, views = stored_views(store, seeing_model, [5, 9, 1])
        assert ids.tolist() == [1, 5]
        np.testing.assert_array_equal(views[1], signatures[4].views.descriptors)  # type: ignore[union-attr]
        codes = all_codes(store, "view_codes", CODE_BYTES)[1]
        np.testing.assert_array_equal(codes, [signature.view_code for signature in signatures])
        store.remove_shapes([1])
        assert stored_views(store, seeing_model, [1, 5])[0].tolist() == [5]


def test_views_of_another_model_are_refused(
    path: Path, model: ShapeModel, seeing_model: ShapeModel, meshes: list[Mesh]
) -> None:
    signature = seeing_model.describe(meshes[0])
    with (
        Library.open(path, model) as library,
        pytest.raises(LibraryError, match=r"'a ball' was described with another model .* its views"),
    ):
        library.add_signature(signature, "a ball")


def test_neighbours(place: str, model: ShapeModel, make_signature: SignatureMaker) -> None:
    with Library.open(place, model) as library:
        for seed in range(4):
            library.add_signature(make_signature(seed), "shape")
    near = np.array([3, 2], np.int64), np.array([0.5, 0.75], np.float32)
    none = np.empty(0, np.int64), np.empty(0, np.float32)
    with opened_store(place, model) as store:
        assert store.without_neighbours(0, 10) == [1, 2, 3, 4]
        store.put_neighbours({1: near, 2: none, 9: near})
        found = store.neighbours([1, 2, 3, 9])
        assert sorted(found) == [1, 2]
        assert [values.tolist() for values in found[1]] == [[3, 2], [0.5, 0.75]]
        assert [values.tolist() for values in found[2]] == [[], []]
        assert store.without_neighbours(0, 1) == [3]
        assert store.without_neighbours(3, 10) == [4]
        store.put_neighbours({1: none})
        assert store.neighbours([1])[1][0].tolist() == []
        store.remove_shapes([1])
        assert store.neighbours([1]) == {}


def test_damaged_neighbours_are_named(path: Path, model: ShapeModel, make_signature: SignatureMaker) -> None:
    with Library.open(path, model) as library:
        library.add_signature(make_signature(1), "shape")
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.execute("INSERT INTO neighbours VALUES (1, x'0102', x'03')")
    with opened(path) as store, pytest.raises(LibraryError, match="the neighbours of shape 1 cannot be read"):
        store.neighbours([1])


def test_an_earlier_library_is_read_as_it_is_and_changed_by_the_first_write(
    path: Path, model: ShapeModel, seeing_model: ShapeModel, meshes: list[Mesh]
) -> None:
    with Library.open(path, model) as library:
        library.add(meshes[0], "old", source="old.ply")
    downgrade(path, model)
    before = path.read_bytes()
    with Library.open(path, seeing_model, read_only=True) as library:
        assert library.model.views is not None
        assert (library.info()["schema"], library.info()["without_views"]) == (7, 1)
        assert library.reindexing_advice() == (
            "views are missing for 1 of 1 shape, described by an earlier version of Shape Google; index "
            "their folders again to find more of the same kind"
        )
        assert library.signature(1).views is None
        assert [match.name for match in library.query(meshes[1])] == ["old"]
        assert library.sources_without_views() == {"old.ply"}
    with opened(path) as store:
        assert store.neighbours([1]) == {}
        assert store.without_neighbours(0, 9) == [1]
        assert store.views([1], 7)[0] == []
    assert path.read_bytes() == before
    with Library.open(path, seeing_model) as library:
        assert path.read_bytes() == before
        library.add(meshes[1], "new", source="new.ply")
        assert (library.info()["schema"], library.info()["without_views"]) == (8, 1)
        assert library.signature(2).views is not None
        assert library.sources_without_views() == {"old.ply"}
    with Library.open(path) as library:  # by now with the views in its own model
        assert library.model.views is not None
        library.add(meshes[0], "old", source="old.ply")
        assert library.reindexing_advice() == ""
        assert library.sources_without_views() == frozenset()


def test_an_interrupted_first_write_leaves_the_earlier_library(
    path: Path, model: ShapeModel, make_signature: SignatureMaker
) -> None:
    with Library.open(path, model) as library:
        library.add_signature(make_signature(1), "old")
    downgrade(path, model)
    before = path.read_bytes()
    with opened(path) as store:
        bad = replace(make_signature(2), area=float("nan"))  # NaN is NULL, which the table refuses
        with pytest.raises(LibraryError):
            store.add(SourceKey("", "a"), NewShape(bad, "bad"))
        assert path.read_bytes() == before
        assert store.neighbours([1]) == {}
        store.add(SourceKey("", "a"), NewShape(make_signature(3), "good"))
        assert store.neighbours([1]) == {}
        assert store.summary().format == 8
