# SPDX-License-Identifier: MIT
"""A root that lies elsewhere on this computer: the sources of a library that others have filled."""

from __future__ import annotations

from pathlib import Path

import pytest

from shapegoogle_core.cli.parser import main
from shapegoogle_core.errors import LibraryError
from shapegoogle_core.indexing import find_meshes, index_files
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import Rearrangement, Root

ELSEWHERE = ["/mnt/on another computer", "Z:\\Assets"]


@pytest.fixture(params=ELSEWHERE)
def shared(request: pytest.FixtureRequest, indexed: Library, folder: Path) -> Library:
    """A library whose root has the path of another computer, of the same system or of Windows."""
    indexed.add_root(folder, "assets")
    keys = [source.key for source in indexed.sources().values()]
    there = Rearrangement(roots=(("assets", request.param),), moved=tuple((key, key) for key in keys))
    indexed._store.rearrange(there)
    assert all(path.startswith(request.param) for path in indexed.sources())
    return indexed


def test_everything_knows_the_local_paths(shared: Library, folder: Path) -> None:
    stored = shared.roots()
    shared.map_root("assets", folder)
    paths = [str(path) for path in find_meshes([folder])]
    assert shared.roots() == [Root("assets", str(folder), 3, stored[0].path)]
    assert list(shared.sources()) == paths
    assert sorted(shape.source for shape in shared.shapes()) == paths
    assert index_files(shared, paths, IndexSettings(jobs=1)).unchanged == 3
    assert len(shared._store.filtered_ids(Filter(folder=folder / "more"))) == 1
    assert len(shared._store.filtered_ids(Filter(sources=(paths[0],)))) == 1
    assert shared.missing(folder) == []
    assert shared.add_root(folder, "assets").path == str(folder)
    # Nothing of it is stored.
    with Library.open(shared.name, read_only=True) as other:
        assert other.roots() == stored
        assert len(other) == 3


def test_a_root_that_is_not_there_is_named(shared: Library, folder: Path) -> None:
    with pytest.raises(LibraryError, match="has no root 'props'; its roots: 'assets'"):
        shared.map_root("props", folder)


def test_commands_take_the_place_of_a_root(
    shared: Library, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place, root = shared.name, f"assets={folder}"
    assert main(["index", "--root", root, "--library", place, "--dry-run"]) == 0
    assert "3 files unchanged" in capsys.readouterr().out
    assert main(["forget", str(folder / "more"), "--root", root, "--library", place, "--dry-run"]) == 0
    assert str(folder / "more" / "plum.stl") in capsys.readouterr().out
