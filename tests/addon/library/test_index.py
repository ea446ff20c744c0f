# SPDX-License-Identifier: MIT
"""Indexing folders and the open scene."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import bpy
import pytest

from shapegoogle_core import Library
from shapegoogle_core.indexing import FileOutcome, IndexSummary
from tests.addon.shapes import add_folder, digests, lumpy


def test_index_a_folder(folder: Path, preferences: Any, session: Any) -> None:
    before = digests(folder)
    add_folder(preferences, folder)
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    assert not session.indexing
    assert session.summary == "4 shapes added from 4 files, 1 input failed"
    assert [(error.name, "broken.blend" in error.reason) for error in session.errors] == [
        ("broken.blend", True)
    ]
    with Library.open(preferences.library) as library:
        assert {(shape.object_name, Path(shape.source).name) for shape in library.shapes()} == {
            ("Apple", "apple.blend"),
            ("Pear", "pear.blend"),
            ("Plum", "plum.blend"),
            ("", "nut.obj"),
        }
        assert all(library.thumbnail(shape.shape_id) for shape in library.shapes())
    assert digests(folder) == before

    # A second time there is nothing to do; a changed file is read again.
    bpy.ops.shape_google.index_library()
    assert session.summary == "4 files unchanged, 1 input failed"
    (error,) = session.errors
    assert error.reason.endswith("Retry Failed Files tries it again)")
    status = (folder / "pear.blend").stat()
    os.utime(folder / "pear.blend", ns=(status.st_atime_ns, status.st_mtime_ns + 10**9))
    (folder / "broken.blend").unlink()
    bpy.ops.shape_google.index_library()
    assert session.summary == "4 files unchanged"


def test_a_root_that_is_another_folder_here(folder: Path, preferences: Any, session: Any) -> None:
    for file in folder.glob("*.blend"):
        file.unlink()
    with Library.open(preferences.library_path()) as library:
        library.add_root(folder.parent / "as on the server", "props")
    for lines, path in ((preferences.roots, str(folder)), (session.roots, "")):
        line = lines.add()
        line.name, line.path = "props", path
    add_folder(preferences, folder)
    bpy.ops.shape_google.index_library()
    preferences.roots.clear()
    with Library.open(preferences.library_path()) as library:
        assert [(root.name, root.source_count) for root in library.roots()] == [("props", 1)]


def test_the_scene_itself(preferences: Any, session: Any) -> None:
    lumpy("First", 0)
    lumpy("Second", 1)
    preferences.use_scene = True
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    assert session.summary == "2 shapes of this scene"
    bpy.context.view_layer.objects.active = bpy.data.objects["First"]
    bpy.ops.object.select_all(action="DESELECT")
    session.collapse = False
    bpy.ops.shape_google.find_similar()
    assert [(match.name, match.in_scene) for match in session.matches] == [("First", True), ("Second", True)]
    assert not bpy.ops.shape_google.append_match.poll()
    bpy.ops.shape_google.choose_match(index=1)
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    assert [item.name for item in bpy.context.selected_objects] == ["Second"]


def test_the_scene_and_its_file_are_one_source(folder: Path, preferences: Any) -> None:
    (folder / "broken.blend").unlink()
    bpy.ops.wm.open_mainfile(filepath=str(folder / "pear.blend"), load_ui=False)
    item = lumpy("Unsaved", 5)
    item.asset_mark()
    item.asset_data.tags.new("lump")
    add_folder(preferences, folder)
    preferences.use_scene = True
    bpy.ops.shape_google.index_library()
    session = bpy.context.window_manager.shape_google
    assert session.summary == "4 shapes added from 4 files; 2 shapes of this scene"
    with Library.open(preferences.library) as library:
        assert {shape.name: shape.tags for shape in library.shapes() if shape.tags} == {"Unsaved": ("lump",)}
        assert len(library) == 5
    # What is on the disk is read again, in case only that is wanted.
    bpy.ops.shape_google.index_library()
    assert session.summary == "1 shape updated from 1 file, 3 files unchanged; 2 shapes of this scene"
    session.collapse = False
    bpy.ops.shape_google.find_similar()
    assert session.matches[0].name == "Unsaved"
    assert [match.in_scene for match in session.matches if match.name == "Pear"] == [True]
    preferences.use_scene = False
    bpy.ops.shape_google.index_library()
    with Library.open(preferences.library) as library:
        assert "Unsaved" not in {shape.name for shape in library.shapes()}
        assert len(library) == 4
    bpy.ops.wm.read_homefile(use_empty=True)


def test_a_cancelled_scene_stores_nothing(addon: ModuleType, preferences: Any, session: Any) -> None:
    for seed in range(3):
        lumpy(f"Shape {seed}", seed)
    module = importlib.import_module(f"{addon.__name__}.library.scene_source")
    indexing = module.SceneIndexing(bpy.context, preferences.library_path(), "default")
    indexing.events()
    indexing.cancel()
    indexing.join()
    assert indexing.events() == []
    with Library.open(preferences.library) as library:
        assert len(library) == 0
    # Objects that are deleted meanwhile are left out; a model that is not there is said.
    indexing = module.SceneIndexing(bpy.context, preferences.library_path(), "default")
    bpy.data.objects.remove(bpy.data.objects["Shape 1"])
    events = []
    while indexing.exit_code is None:
        indexing.join()
        events += indexing.events()
    outcomes = [event for event in events if isinstance(event, FileOutcome)]
    assert [str(outcome.path) for outcome in outcomes] == ["Shape 0", "Shape 2"]
    assert isinstance(events[-1], IndexSummary)
    assert events[-1].sentence() == "2 shapes of this scene"
    Path(preferences.library).unlink()
    indexing = module.SceneIndexing(bpy.context, preferences.library_path(), "/no/model.npz")
    while indexing.exit_code is None:
        indexing.join()
        assert indexing.events() == []
    assert indexing.exit_code == 2
    assert "cannot read the model" in indexing.last_words()


def test_hidden_objects_and_wires_are_left_out_of_the_scene(preferences: Any, session: Any) -> None:
    lumpy("Hidden", 0).hide_viewport = True
    lumpy("Shown", 1)
    wire = bpy.data.meshes.new("wire")
    wire.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    bpy.context.collection.objects.link(bpy.data.objects.new("Wire", wire))
    preferences.use_scene = True
    bpy.ops.shape_google.index_library()
    assert session.summary == (
        "1 shape of this scene; 2 objects skipped: 1 hidden object, 1 mesh without faces"
    )
    assert not session.errors


def test_a_fault_is_copied_with_its_details(addon: ModuleType, session: Any) -> None:
    """Nobody can ask a button for --verbose."""
    module = importlib.import_module(f"{addon.__name__}.library.index")
    reason = "'a.blend' was lost; index it again, and report it with what --verbose shows"
    outcomes = [
        FileOutcome(Path("/x/a.blend"), "failed", reason, "Traceback of a\n  line 3\n"),
        FileOutcome(Path("/x/b.off"), "failed", "'b.off' is damaged"),
    ]
    module._take(SimpleNamespace(events=lambda: outcomes, exit_code=None))
    assert module._text_of(session.errors) == (
        "/x/a.blend: 'a.blend' was lost; index it again, and report it with what Copy Errors copies"
        "\nTraceback of a\n  line 3\n/x/b.off: 'b.off' is damaged"
    )


def test_where_nothing_is_indexed_the_only_reason_is_said_at_once(
    preferences: Any, session: Any, tmp_path: Path
) -> None:
    folder = tmp_path / "away"
    folder.mkdir()
    add_folder(preferences, folder)
    folder.rmdir()
    bpy.ops.shape_google.index_library()
    assert session.summary == "1 input failed: 'away' does not exist; check the spelling"
    assert [error.reason for error in session.errors] == ["'away' does not exist; check the spelling"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such names")
def test_forty_broken_files(preferences: Any, session: Any, tmp_path: Path) -> None:
    """The summary is longer than any pipe takes at once, and beside it the list of errors is printed."""
    folder = tmp_path.joinpath("assets", *["}\n{ long name of a folder " * 8] * 8)
    folder.mkdir(parents=True)
    for number in range(40):
        (folder / f"{number:02}.off").write_text("OFF\n")
    add_folder(preferences, tmp_path / "assets")
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    assert session.summary == "40 inputs failed"
    assert {error.path for error in session.errors} == {str(path) for path in folder.iterdir()}
