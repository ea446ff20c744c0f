# SPDX-License-Identifier: MIT
"""Matches are found in files that are saved for the first time, and under new names of their objects."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from shapegoogle_core import Library
from tests.addon.shapes import lumpy


@pytest.fixture
def new_file(blender: Any) -> Any:
    """An empty file that was never saved; opening it again gives another one."""

    def open_new() -> None:
        bpy.ops.wm.read_homefile(use_empty=True)

    open_new()
    yield open_new
    open_new()


@pytest.fixture
def index(preferences: Any) -> Any:
    """Index the scene; returns the sources and the names of the shapes in the library afterwards."""
    preferences.use_scene = True

    def run() -> list[tuple[str, str]]:
        assert bpy.ops.shape_google.index_library() == {"FINISHED"}
        with Library.open(preferences.library) as library:
            return sorted((record.source, record.object_name) for record in library.shapes())

    return run


def find(name: str) -> Any:
    for item in bpy.context.view_layer.objects:
        item.select_set(item.name == name)
    bpy.context.view_layer.objects.active = bpy.data.objects[name]
    session = bpy.context.window_manager.shape_google
    session.collapse = False
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    return session


def choose(session: Any, name: str) -> Any:
    session.active_match = [match.object_name for match in session.matches].index(name)
    return session.matches[session.active_match]


def selected() -> list[str]:
    return sorted(item.name for item in bpy.context.selected_objects)


def test_an_unsaved_file_is_no_other_unsaved_file(new_file: Any, index: Any) -> None:
    lumpy("Cube", 0)
    ((first, _),) = index()
    assert first.startswith("Unsaved file ")
    new_file()
    lumpy("Cube", 1)
    session = find("Cube")
    match = choose(session, "Cube")
    assert (match.source, match.in_scene) == (first, False)
    assert not bpy.ops.shape_google.select_match.poll()
    with pytest.raises(RuntimeError, match="never saved"):
        bpy.ops.shape_google.append_match()
    assert [name for _, name in index()] == ["Cube", "Cube"]


def test_saving_takes_the_shapes_over(new_file: Any, index: Any, preferences: Any, tmp_path: Path) -> None:
    lumpy("Pear", 0)
    index()
    session = find("Pear")
    copy, path = str(tmp_path / "copy.blend"), str(tmp_path / "pear.blend")
    bpy.ops.wm.save_as_mainfile(filepath=copy, copy=True)
    assert session.matches[0].source.startswith("Unsaved file ")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert session.matches[0].source == path
    choose(session, "Pear")
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    with Library.open(preferences.library) as library:
        assert [(record.source, record.object_name) for record in library.shapes()] == [(path, "Pear")]
        assert [root.path for root in library.roots()] == [str(tmp_path)]
    assert index() == [(path, "Pear")]
    # Under another name it is another file; the first one is where it was.
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "other.blend"))
    assert index() == [(str(tmp_path / "other.blend"), "Pear"), (path, "Pear")]
    new_file()
    lumpy("Query", 0)
    session = find("Query")
    session.active_match = [match.source for match in session.matches].index(path)
    assert not session.matches[session.active_match].in_scene
    assert bpy.ops.shape_google.append_match() == {"FINISHED"}


def test_a_saved_file_in_an_indexed_folder_is_one_source(
    new_file: Any, index: Any, preferences: Any, tmp_path: Path
) -> None:
    lumpy("Pear", 0)
    index()
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real", target_is_directory=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "link" / "pear.blend"))
    folder = preferences.folders.add()
    folder.path = str(tmp_path / "real")
    assert index() == [(str(tmp_path / "real" / "pear.blend"), "Pear")]
    session = find("Pear")
    assert session.matches[0].in_scene


def test_a_renamed_object_is_found(new_file: Any, index: Any) -> None:
    lumpy("Pear", 0)
    lumpy("Plum", 1)
    index()
    session = find("Pear")
    bpy.data.objects["Plum"].name = "Damson"
    bpy.data.objects["Pear"].name = "Plum"
    choose(session, "Plum")
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    assert selected() == ["Damson"]
    # A new search in the same session knows them too, and so does one after the file was opened again.
    session = find("Damson")
    choose(session, "Pear")
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    assert selected() == ["Plum"]


def test_a_renamed_object_is_found_by_its_mesh_in_another_session(
    new_file: Any, index: Any, tmp_path: Path
) -> None:
    lumpy("Pear", 0)
    lumpy("Plum", 1).modifiers.new("Subdivision", "SUBSURF")
    path = str(tmp_path / "fruit.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    index()
    bpy.data.objects["Plum"].name = "Damson"
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False)
    session = find("Pear")
    assert choose(session, "Plum").in_scene
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    assert selected() == ["Damson"]
    new_file()
    lumpy("Query", 0)
    session = find("Query")
    before = {item.name for item in bpy.data.objects} | {data.name for data in bpy.data.meshes}
    choose(session, "Plum")
    assert bpy.ops.shape_google.append_match() == {"FINISHED"}
    assert bpy.context.active_object.name == "Damson"
    after = {item.name for item in bpy.data.objects} | {data.name for data in bpy.data.meshes}
    assert len(after - before) == 2  # the object and its mesh, no trials


def test_what_is_gone_is_said(new_file: Any, index: Any, tmp_path: Path) -> None:
    lumpy("Pear", 0)
    lumpy("Plum", 1)
    index()
    session = find("Pear")
    bpy.data.objects.remove(bpy.data.objects["Plum"])
    choose(session, "Plum")
    assert not bpy.ops.shape_google.select_match.poll()
    with pytest.raises(RuntimeError, match="'Plum' is not in this scene any more"):
        bpy.ops.shape_google.append_match()


def test_another_scene_of_the_file_is_named(new_file: Any, index: Any) -> None:
    lumpy("Pear", 0)
    plum = lumpy("Plum", 1)
    index()
    session = find("Pear")
    bpy.data.scenes.new("Attic").collection.objects.link(plum)
    bpy.context.collection.objects.unlink(plum)
    bpy.context.view_layer.update()
    assert not choose(session, "Plum").in_scene
    with pytest.raises(RuntimeError, match="'Plum' is in another scene of this file, 'Attic'; switch"):
        bpy.ops.shape_google.append_match()
    bpy.data.scenes.remove(bpy.data.scenes["Attic"])


def test_select_goes_through_the_placements(new_file: Any, index: Any) -> None:
    first = lumpy("Bolt", 0)
    for number, scale in enumerate((1, 2, -1), 1):
        copy = first.copy()
        copy.name, copy.scale, copy.location = f"Bolt {number}", (scale, scale, scale), (5 * number, 0, 0)
        bpy.context.collection.objects.link(copy)
    lumpy("Plum", 1)
    bpy.context.view_layer.update()
    assert [name for _, name in index()] == ["Bolt", "Plum"]
    session = find("Plum")
    match = choose(session, "Bolt")
    assert match.placement_count == 4
    bpy.data.objects["Bolt 1"].name = "Screw"
    seen = []
    for _ in range(5):
        assert bpy.ops.shape_google.select_match() == {"FINISHED"}
        seen += selected()
    assert seen == ["Bolt", "Screw", "Bolt 2", "Bolt 3", "Bolt"]
    assert bpy.ops.shape_google.select_match(all=True) == {"FINISHED"}
    assert selected() == ["Bolt", "Bolt 2", "Bolt 3", "Screw"]


def test_evidence_and_append_are_of_the_placement_that_fits(
    new_file: Any, index: Any, tmp_path: Path
) -> None:
    first = lumpy("Wing", 0)
    for name, scale in (("Mirrored", (-1, 1, 1)), ("Large", (2, 2, 2))):
        copy = first.copy()
        copy.name, copy.scale, copy.location = name, scale, (9, 0, 0)
        bpy.context.collection.objects.link(copy)
    bpy.context.view_layer.update()
    path = str(tmp_path / "wings.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert [name for _, name in index()] == ["Wing"]
    for name in ("Wing", "Mirrored", "Large"):
        match = find(name).matches[0]
        assert (match.object_name, match.evidence) == (name, "identical")
        assert match.size == pytest.approx(1)
    large = np.array(bpy.data.objects["Large"].dimensions)
    new_file()
    item = lumpy("Query", 0)
    item.scale = 2, 2, 2
    bpy.context.view_layer.update()
    match = find("Query").matches[0]
    assert match.object_name == "Large"
    assert bpy.ops.shape_google.append_match() == {"FINISHED"}
    assert bpy.context.active_object.name == "Large"
    np.testing.assert_allclose(bpy.context.active_object.dimensions, large, rtol=1e-5)


def test_a_scene_whose_file_is_closed_meanwhile_is_not_stored(
    addon: ModuleType, new_file: Any, preferences: Any
) -> None:
    lumpy("Pear", 0)
    module = importlib.import_module(f"{addon.__name__}.library.scene_source")
    indexing = module.SceneIndexing(bpy.context, preferences.library_path(), "default")
    indexing.events()
    new_file()
    assert indexing.events() == []
    assert "another file was opened" in indexing.last_words()
