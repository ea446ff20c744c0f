# SPDX-License-Identifier: MIT
"""Folders that were moved, folders and files that are to be forgotten."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import pytest

from shapegoogle_core import Library
from tests.addon.shapes import digests, lumpy


def sources(preferences: Any) -> list[str]:
    with Library.open(preferences.library) as library:
        return sorted(source.path for source in library.sources().values() if source.error is None)


def find(name: str, source: Path) -> Any:
    """Search with a new object and choose the match in a file."""
    lumpy("Query", 1)
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    session = bpy.context.window_manager.shape_google
    session.active_match = [match.source for match in session.matches].index(str(source))
    assert session.matches[session.active_match].object_name == name
    return session


def test_a_moved_folder_is_followed(indexed: Path, preferences: Any) -> None:
    session = find("Pear", indexed / "pear.blend")
    moved = indexed.rename(indexed.with_name("moved"))
    with pytest.raises(RuntimeError, match="does not exist any more; Move Sources"):
        bpy.ops.shape_google.append_match()
    before = digests(moved)
    assert bpy.ops.shape_google.move_sources(old=str(indexed), new=str(moved)) == {"FINISHED"}
    assert session.summary == f"5 files moved to '{moved}'"
    assert bpy.ops.shape_google.append_match() == {"FINISHED"}
    assert bpy.context.active_object.name == "Pear"
    assert [item.path for item in preferences.folders] == [str(moved)]
    # Nothing is read again, and nothing is in the library twice.
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    assert session.summary.startswith("4 files unchanged")
    assert {Path(path).parent for path in sources(preferences)} == {moved}
    assert digests(moved) == before


def test_an_empty_place_is_refused(indexed: Path, preferences: Any, tmp_path: Path) -> None:
    before = sources(preferences)
    (tmp_path / "empty").mkdir()
    for new in ("empty", "nowhere"):
        with pytest.raises(RuntimeError):
            bpy.ops.shape_google.move_sources(old=str(indexed), new=str(tmp_path / new))
    with pytest.raises(RuntimeError, match="elsewhere"):
        bpy.ops.shape_google.move_sources(old=str(tmp_path / "elsewhere"), new=str(tmp_path / "empty"))
    assert sources(preferences) == before


def test_a_folder_is_forgotten_and_does_not_come_back(indexed: Path, preferences: Any, session: Any) -> None:
    before = digests(indexed)
    assert bpy.ops.shape_google.forget_folder(folder=str(indexed)) == {"FINISHED"}
    assert session.summary == (
        f"5 files, 4 shapes of '{indexed}' forgotten; it is switched off below Sources"
    )
    assert sources(preferences) == []
    assert session.shape_count == 0
    assert [item.use for item in preferences.folders] == [False]
    assert digests(indexed) == before


def test_only_files_that_are_certainly_gone_are_forgotten(
    indexed: Path, preferences: Any, session: Any, tmp_path: Path
) -> None:
    (indexed / "plum.blend").unlink()
    (indexed / "broken.blend").unlink()
    bpy.ops.shape_google.index_library()
    assert session.summary == "3 files unchanged"
    assert bpy.ops.shape_google.forget_missing() == {"FINISHED"}
    assert session.summary == "2 files, 1 shape forgotten"
    assert [Path(path).name for path in sources(preferences)] == ["apple.blend", "nut.obj", "pear.blend"]
    # The drive of the folder is not connected.
    indexed.rename(tmp_path / "away")
    assert bpy.ops.shape_google.forget_missing() == {"FINISHED"}
    assert session.summary == "0 files, 0 shapes forgotten; 3 files of folders that are not here stay"
    assert len(sources(preferences)) == 3


def test_unsaved_files_are_forgotten_once_they_are_closed(
    blender: Any, preferences: Any, session: Any
) -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    lumpy("Pear", 0)
    preferences.use_scene = True
    bpy.ops.shape_google.index_library()
    bpy.ops.shape_google.forget_missing()
    assert len(sources(preferences)) == 1
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.shape_google.forget_missing()
    assert sources(preferences) == []
