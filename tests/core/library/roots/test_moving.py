# SPDX-License-Identifier: MIT
"""Moving and forgetting the sources of a library, on real folders."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.indexing import IndexReport, find_meshes, index_files
from shapegoogle_core.indexing.settings import IndexSettings
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.roots.moving import plan_move
from shapegoogle_core.library.storage.records import Root, SourceKey, SourceRecord


@pytest.fixture
def rooted(indexed: Library, folder: Path) -> Library:
    """A library that knows `folder` as a root."""
    indexed.add_root(folder)
    return indexed


def index(library: Library, folder: Path) -> IndexReport:
    """Index files whose content is known, so that no process starts."""
    return index_files(library, find_meshes([folder]), IndexSettings(jobs=1))


def state(library: Library) -> dict[int, str]:
    return {shape.shape_id: shape.source for shape in library.shapes()}


def relative(library: Library, folder: Path) -> list[str]:
    return sorted(str(Path(source).relative_to(folder)) for source in library.sources())


EVERYTHING = ["apple.off", "more/plum.stl", "pear.obj"]


def test_a_moved_root(rooted: Library, folder: Path) -> None:
    before = state(rooted)
    new = folder.parent / "elsewhere" / "fruit"
    new.parent.mkdir()
    folder.rename(new)
    planned = rooted.move(folder, new, dry_run=True)
    assert (len(planned.sources), planned.found, planned.missing, planned.merged) == (3, 3, (), ())
    assert planned.roots == (("meshes", str(folder), str(new)),)
    assert state(rooted) == before
    assert rooted.move(folder, new) == planned
    assert rooted.roots() == [Root("meshes", str(new), 3)]
    assert set(state(rooted)) == set(before)
    assert relative(rooted, new) == EVERYTHING
    assert index(rooted, new).unchanged == 3
    assert len(rooted) == 3
    with pytest.raises(LibraryError, match="no indexed file lies below"):
        rooted.move(folder, new)


def test_files_with_other_times_are_not_read_again(rooted: Library, folder: Path, tmp_path: Path) -> None:
    """As copying to another disk leaves them."""
    new = tmp_path / "copy"
    shutil.copytree(folder, new, copy_function=shutil.copy)
    before = set(state(rooted))
    rooted.move(folder, new)
    assert index(rooted, new).unchanged == 3
    assert set(state(rooted)) == before


def test_a_folder_above_and_one_below_a_root(rooted: Library, folder: Path, tmp_path: Path) -> None:
    top, new = tmp_path / "top", tmp_path / "new"
    top.mkdir()
    folder.rename(top / "meshes")
    rooted.move(folder, top / "meshes")
    top.rename(new)
    rooted.move(top, new)
    assert rooted.roots() == [Root("meshes", str(new / "meshes"), 3)]
    (new / "meshes" / "more").rename(new / "separate")
    report = rooted.move(new / "meshes" / "more", new / "separate")
    assert report.roots == (("separate", "", str(new / "separate")),)
    assert relative(rooted, new) == ["meshes/apple.off", "meshes/pear.obj", "separate/plum.stl"]
    assert [(root.name, root.source_count) for root in rooted.roots()] == [("meshes", 2), ("separate", 1)]
    # Back below the other root, where it stays a root.
    (new / "separate").rename(new / "meshes" / "less")
    rooted.move(new / "separate", new / "meshes" / "less")
    assert [(root.name, root.source_count) for root in rooted.roots()] == [("meshes", 2), ("separate", 1)]
    assert index(rooted, new / "meshes").unchanged == 3


def test_roots_that_overlap_after_a_move(
    rooted: Library, folder: Path, make_mesh: Callable[..., Path]
) -> None:
    other = folder.parent / "other"
    make_mesh(other / "fig.obj", seed=4)
    index(rooted, other)
    shutil.move(other, folder / "other")
    rooted.move(other, folder / "other")
    assert [(root.name, root.source_count) for root in rooted.roots()] == [("meshes", 3), ("other", 1)]
    assert relative(rooted, folder) == sorted([*EVERYTHING, "other/fig.obj"])
    # Into the very folder of the other root: one of them is left.
    shutil.move(folder / "other" / "fig.obj", folder / "fig.obj")
    rooted.move(folder / "other", folder)
    assert rooted.roots() == [Root("meshes", str(folder), 4)]
    assert index(rooted, folder).unchanged == 4


def test_a_folder_that_was_indexed_at_both_places(
    rooted: Library, folder: Path, make_mesh: Callable[..., Path]
) -> None:
    new = folder.parent / "new"
    folder.rename(new)
    make_mesh(new / "pear.obj", seed=5)
    index(rooted, new)
    assert len(rooted) == 6
    changed = next(shape.shape_id for shape in rooted.shapes() if shape.source == str(new / "pear.obj"))
    report = rooted.move(folder, new)
    assert len(report.merged) == 3
    assert relative(rooted, new) == EVERYTHING
    # The source at the new place knows what is in the file now.
    assert changed in state(rooted)
    assert rooted.roots() == [Root("new", str(new), 3)]
    assert index(rooted, new).unchanged == 3


def test_different_files_never_become_one(
    rooted: Library, folder: Path, make_mesh: Callable[..., Path]
) -> None:
    new = folder.parent / "new"
    shutil.copytree(folder, new)
    make_mesh(new / "pear.obj", seed=5)
    index(rooted, new)
    before = state(rooted)
    with pytest.raises(LibraryError, match=r"pear\.obj' would take the place of another source") as error:
        rooted.move(folder, new)
    assert "shapegoogle forget" in str(error.value)
    assert state(rooted) == before


def test_a_wrong_folder(rooted: Library, folder: Path, tmp_path: Path) -> None:
    before = state(rooted)
    with pytest.raises(LibraryError, match=r"none of the 3 files below .* is in"):
        rooted.move(folder, tmp_path)
    with pytest.raises(LibraryError, match="there is no folder"):
        rooted.move(folder, tmp_path / "nowhere")
    with pytest.raises(LibraryError, match="are the same folder"):
        rooted.move(folder, folder.parent / "meshes" / ".")
    with pytest.raises(LibraryError, match="no indexed file lies below '/nowhere'; the library knows"):
        rooted.move("/nowhere", folder)
    assert state(rooted) == before


def test_some_files_are_missing(rooted: Library, folder: Path) -> None:
    new = folder.parent / "new"
    folder.rename(new)
    (new / "pear.obj").unlink()
    report = rooted.move(folder, new)
    assert (report.found, report.missing) == (2, (str(new / "pear.obj"),))
    assert relative(rooted, new) == EVERYTHING


def test_labels_below_the_folder_move_too(rooted: Library, folder: Path) -> None:
    signature = rooted.signature(1)
    label = f"{folder}/scene.blend (open scene)"
    shape_id = rooted.add_signature(signature, "a", source=label)
    rooted.add_signature(signature, "b", source="scene.blend")
    new = folder.parent / "new"
    folder.rename(new)
    rooted.move(folder, new)
    assert state(rooted)[shape_id] == f"{new}/scene.blend (open scene)"
    assert "scene.blend" in rooted.sources()


def test_from_another_system() -> None:
    """A library from Windows is opened elsewhere: case counts there, and keys change."""
    roots = [Root("models", r"\\nas\Models", 2)]
    sources = [
        SourceRecord(rf"\\nas\Models\{name}", 1, 1, "ab", None, 1, "models", name.replace("\\", "/"))
        for name in (r"Chairs\Oak.obj", "Ash.obj")
    ]
    there = {"/mnt/models/Chairs/Oak.obj", "/mnt/models/Ash.obj"}
    report = plan_move(r"\\NAS\models", "/mnt/models", roots, sources, there.__contains__)
    assert (report.found, report.missing) == (2, ())
    assert report.changes.roots == (("models", "/mnt/models"),)
    # Their keys differ in case, though their roots and paths do not.
    assert set(report.changes.moved) == {
        (SourceKey("models", "Chairs/Oak.obj"), SourceKey("models", "Chairs/Oak.obj")),
        (SourceKey("models", "Ash.obj"), SourceKey("models", "Ash.obj")),
    }


# -- forgetting ---------------------------------------------------------------------------------------------


def test_forget_folders_and_sources(rooted: Library, folder: Path) -> None:
    before = state(rooted)
    rooted.add_signature(rooted.signature(1), "a", source="a label")
    planned = rooted.forget([folder / "more", "a label"], dry_run=True)
    assert set(planned.forgotten) == {str(folder / "more" / "plum.stl"), "a label"}
    assert (planned.shape_count, len(rooted)) == (2, 4)
    assert rooted.forget([folder / "more", "a label"]) == planned
    assert set(state(rooted).values()) == set(before.values()) - {str(folder / "more" / "plum.stl")}
    assert rooted.forget(folder / "pear.obj").shape_count == 1
    # All of a root: the root goes too, also if its folder is gone.
    shutil.rmtree(folder)
    assert rooted.forget(folder).forgotten == (str(folder / "apple.off"),)
    assert (len(rooted), rooted.roots(), rooted.sources()) == (0, [], {})


def test_forget_nothing_by_mistake(rooted: Library, folder: Path) -> None:
    with pytest.raises(LibraryError, match="is no source of the library"):
        rooted.forget([folder, folder / "mor"])
    with pytest.raises(ValueError, match="name the folders"):
        rooted.forget()
    assert len(rooted) == 3


def test_forget_missing_files(rooted: Library, folder: Path) -> None:
    assert rooted.forget(missing=True).forgotten == ()
    (folder / "pear.obj").unlink()
    shutil.rmtree(folder / "more")
    assert rooted.forget(missing=True, dry_run=True).shape_count == 2
    assert rooted.forget(folder / "more" / "..", missing=True).forgotten == (
        str(folder / "more" / "plum.stl"),
        str(folder / "pear.obj"),
    )
    assert relative(rooted, folder) == ["apple.off"]


@pytest.mark.parametrize("away", ["unplugged", "not mounted"])
def test_a_drive_that_is_away_keeps_its_files(rooted: Library, folder: Path, away: str) -> None:
    shutil.rmtree(folder)
    if away == "not mounted":
        folder.mkdir()
    report = rooted.forget(missing=True)
    assert (report.forgotten, report.kept) == ((), ((str(folder), 3),))
    if away == "unplugged":
        with pytest.raises(LibraryError, match=r"does not exist, so its files stay .* `shapegoogle move`"):
            rooted.forget(folder, missing=True)
    assert len(rooted) == 3
    assert rooted.forget(folder).shape_count == 3


def test_a_drive_inside_a_root(rooted: Library, folder: Path) -> None:
    (folder / "more" / "plum.stl").unlink()
    report = rooted.forget(missing=True)
    assert (report.forgotten, report.kept) == ((), ((str(folder / "more"), 1),))
    assert rooted.remove_missing(folder) == []
    (folder / "more" / "readme.txt").touch()
    assert rooted.missing(folder) == [str(folder / "more" / "plum.stl")]
    assert len(list(rooted.query(rooted.signature(1), where=Filter(folder=folder / "more")))) == 1
