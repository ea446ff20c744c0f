# SPDX-License-Identifier: MIT
"""Copies of libraries between files and databases, and upgrades."""

from __future__ import annotations

import sqlite3
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import psycopg
import pytest

import shapegoogle_core as sg
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.origin import Origin
from shapegoogle_core.library.placement import Placement
from shapegoogle_core.library.storage.address import as_place
from shapegoogle_core.library.storage.opening import open_store
from shapegoogle_core.library.storage.records import NewShape
from shapegoogle_core.library.storage.store import Store, all_codes
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.views import CODE_BYTES, ViewModel, packed_size
from tests.core.postgresql_server import PostgresqlServer


@pytest.fixture
def seeing(model: ShapeModel, view_model: ViewModel) -> ShapeModel:
    return model.with_parts(views=view_model)


@pytest.fixture
def full(place: str, tmp_path: Path, seeing: ShapeModel, meshes: list[Mesh]) -> str:
    """A library with everything that one can have: roots, labels, placements, pictures, decisions, gaps."""
    (tmp_path / "models").mkdir()
    with Library.open(place, seeing) as library:
        library.add_root(tmp_path / "models", "models")
        described = [seeing.describe(mesh) for mesh in meshes]
        placed = (Placement("one", np.eye(4)), Placement("two", np.diag([2.0, 2, 2, 1])))
        shapes = [
            NewShape(described[0], "a", "a", b"png", ("wood", "it's"), placed, preview=b"small"),
            NewShape(described[1], "half \ud83d b", "b", origin=Origin("text", "Props/Signs", 7)),
        ]
        file = tmp_path / "models" / "x.blend"
        library.replace_source(file, size=5, mtime_ns=6, sha256="ab", shapes=shapes)
        library.replace_source(tmp_path / "models" / "y.obj", size=1, mtime_ns=1, sha256="cd", error="broken")
        for number, signature in enumerate(described[2:]):
            library.add_signature(signature, f"shape {number}", source="a label" if number else "")
        library.decide("tag", 3, tag="decided", author="ana")
        library.decide("keep both", 1, 2)
        library.remove_shape(5)
    return place


@pytest.fixture
def other_place(request: pytest.FixtureRequest, place: str, tmp_path: Path) -> str:
    """A new database for a file, and a new file for a database."""
    if place.startswith("postgresql:"):
        return str(tmp_path / "copy.sglib")
    url: str = request.getfixturevalue("postgresql_url")
    return url


def opened(place: str) -> closing[Store]:
    return closing(open_store(as_place(place), None, read_only=True, timeout=5)[0])


def content(place: str, model: ShapeModel) -> dict[str, object]:
    """Everything that a store gives away."""
    assert model.views is not None
    with opened(place) as store:
        ids = [record.shape_id for record in store.shapes_after(0, 100)]
        return {
            "records": store.shapes_after(0, 100),
            "sources": store.sources(),
            "roots": store.roots(counted=True),
            "decisions": store.decisions(),
            "placements": repr(store.placements(ids)),
            "bags": store.bags(ids, model.bag_size)[1].tolist(),
            "codes": all_codes(store, "codes", 9)[1].tolist(),
            "view codes": all_codes(store, "view_codes", CODE_BYTES)[1].tolist(),
            "views": store.views(ids, packed_size(model.views.shape))[1].tolist(),
            "samples": store.samples(ids),
            "measures": store.measures(ids),
            "pictures": [(store.thumbnail(i), store.preview(i)) for i in ids],
            "neighbours": repr(store.neighbours(ids)),
            "last": store.last_id(),
        }


def test_a_copy_has_everything(full: str, other_place: str, seeing: ShapeModel) -> None:
    report = sg.copy_library(full, other_place)
    assert (report.copied, report.shapes, report.sources, report.decisions) == (4, 4, 3, 2)
    assert content(other_place, seeing) == content(full, seeing)
    with Library.open(other_place) as library:
        assert library.add_signature(library.signature(1), "new") == 6  # 5 was given before
    with pytest.raises(LibraryError, match="is a library in use; copy into a new one"):
        sg.copy_library(full, other_place)


def test_an_interrupted_copy_goes_on_where_it_was(
    full: str, other_place: str, seeing: ShapeModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shapegoogle_core.library.storage.copying._SHAPES", 1)

    def interrupted(shape_ids: Sequence[int]) -> Iterator[int]:
        yield from shape_ids[:2]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sg.copy_library(full, other_place, interrupted)
    with pytest.raises(LibraryError, match=r"unfinished copy of .* complete it with `shapegoogle copy`"):
        Library.open(other_place)
    with Library.open(other_place, read_only=True) as library:
        assert len(library) == 2
    # Meanwhile the library changes: one of the copied shapes goes, and a new one comes.
    with Library.open(full) as library:
        library.remove_shape(1)
        library.add_signature(library.signature(2), "late", source="late label")
    report = sg.copy_library(full, other_place)
    assert (report.copied, report.shapes) == (3, 4)
    before, after = content(full, seeing), content(other_place, seeing)
    # The copied neighbours of the first run still have the shape that is gone, which searches pass over.
    assert {**before, "neighbours": 0} == {**after, "neighbours": 0}


def test_what_is_decided_during_a_copy_is_copied_with_its_tags(
    full: str, other_place: str, seeing: ShapeModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shapegoogle_core.library.storage.copying._SHAPES", 1)

    def deciding(shape_ids: Sequence[int]) -> Iterator[int]:
        yield from shape_ids
        # Each of these shapes has been copied with the tags that it had.
        with Library.open(full) as library:
            library.undo(1)
            library.decide("tag", 1, tag="late")
            library.decide("no tag", 1, tag="wood")

    sg.copy_library(full, other_place, deciding)
    with Library.open(other_place) as library:
        assert (library.shape(1).tags, library.shape(3).tags) == (("it's", "late"), ())
    assert content(other_place, seeing) == content(full, seeing)


def test_a_copy_of_another_library_is_not_continued(
    full: str, other_place: str, tmp_path: Path, seeing: ShapeModel
) -> None:
    def stopped(shape_ids: Iterable[int]) -> Iterator[int]:
        yield from ()
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sg.copy_library(full, other_place, stopped)
    second = str(tmp_path / "second.sglib")
    Library.open(second, seeing).close()
    with pytest.raises(LibraryError, match="is an unfinished copy of"):
        sg.copy_library(second, other_place)
    with pytest.raises(LibraryError, match="cannot be copied onto itself"):
        sg.copy_library(full, full)


def test_a_file_of_the_format_before_is_upgraded_after_a_copy(path: Path, model: ShapeModel) -> None:
    Library.open(path, model).close()
    assert not sg.upgrade_library(path).upgraded
    with closing(sqlite3.connect(path)) as connection, connection:
        for table in ("views", "view_codes", "view_code_blocks", "neighbours"):
            connection.execute(f"DROP TABLE {table}")
        connection.execute("UPDATE meta SET value = '7' WHERE key = 'schema'")
    report = sg.upgrade_library(path)
    assert report == sg.UpgradeReport(True, path.with_name("shapes.sglib.format-7"), 8)
    for file, version in ((path, 8), (report.backup, 7)):
        assert file is not None
        with Library.open(file, read_only=True) as library:
            assert library.info()["schema"] == version
    with pytest.raises(LibraryError, match="there is no library"):
        sg.upgrade_library(path.with_name("absent.sglib"))


@pytest.mark.skipif(sys.platform == "win32", reason="files have no largest size there")
def test_half_a_backup_is_removed(path: Path, model: ShapeModel) -> None:
    import resource

    Library.open(path, model).close()
    with closing(sqlite3.connect(path)) as connection, connection:
        for table in ("views", "view_codes", "view_code_blocks", "neighbours"):
            connection.execute(f"DROP TABLE {table}")
    before = path.read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) // 2, limits[1]))
    try:
        with pytest.raises(LibraryError):
            sg.upgrade_library(path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_bytes() == before
    assert list(path.parent.glob("*.format-*")) == []
    assert sg.upgrade_library(path).upgraded


def test_a_database_that_lacks_tables_is_upgraded_after_a_dump(
    postgresql: PostgresqlServer,
    postgresql_url: str,
    model: ShapeModel,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PATH", str(postgresql.programs), prepend=":")
    Library.open(postgresql_url, model).close()
    schema = postgresql_url.partition("schema=")[2]
    assert not sg.upgrade_library(postgresql_url).upgraded
    # A table of that name which somebody has made elsewhere is not the library's.
    with psycopg.connect(postgresql.url("shapes")) as connection:
        connection.execute("CREATE TABLE public.decisions ()")
        connection.execute(f"DROP TABLE {schema}.decisions".encode())
    assert sg.upgrade_library(postgresql_url, tmp_path / "first.dump").upgraded
    with psycopg.connect(postgresql.url("shapes").partition("&")[0]) as connection:
        connection.execute("DROP TABLE public.decisions")
        connection.execute(f"DROP TABLE {schema}.decisions".encode())
        connection.execute(f"UPDATE {schema}.meta SET value = '7' WHERE key = 'schema'".encode())
    with pytest.raises(LibraryError, match=r"an older version .* run `shapegoogle upgrade"):
        Library.open(postgresql_url)
    backup = tmp_path / "before.dump"
    report = sg.upgrade_library(postgresql_url, backup)
    assert report == sg.UpgradeReport(True, backup, 8)
    assert backup.stat().st_size > 1_000
    with Library.open(postgresql_url) as library:
        assert library.decisions() == []
    with psycopg.connect(postgresql.url("shapes")) as connection:
        connection.execute(f"UPDATE {schema}.meta SET value = '9' WHERE key = 'schema'".encode())
    with pytest.raises(LibraryError, match=r"a newer version .* update Shape Google on this computer"):
        Library.open(postgresql_url)
