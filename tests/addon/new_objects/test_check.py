# SPDX-License-Identifier: MIT
"""*Check New Objects*: what the library has already is listed, kept, remembered or replaced."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from tests.addon.duplicates.objects import add, farthest, in_world
from tests.addon.shapes import lumpy


@pytest.fixture
def checked(indexed: Path, session: Any, addon: ModuleType) -> Any:
    """A scene with an object of its own, which no check lists any more."""
    lumpy("Mine", 7)
    importlib.import_module(f"{addon.__name__}.new_objects.known").note_all()
    session.check_which = "NEW"
    return session


def check(session: Any) -> dict[str, str]:
    assert bpy.ops.shape_google.check_new_objects() == {"FINISHED"}
    return {line.name: line.match.name for line in session.new_objects}


def test_new_copies_are_listed_once_kept_and_checked_again(checked: Any) -> None:
    assert check(checked) == {}
    assert checked.check_status.startswith("There are no new meshes")
    pear = lumpy("Imported", 1)
    pear.scale, pear.location = (3, 3, 3), (1, 2, 3)
    add("Imported.001", pear.data)
    other = lumpy("Other", 9)
    wire = bpy.data.meshes.new("Wire")
    wire.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    add("Wire", wire)
    assert check(checked) == {"Imported": "Pear"}
    assert checked.check_status == (
        "1 of 3 meshes is in the library already, or nearly; 1 mesh without faces was left out"
    )
    (line,) = checked.new_objects
    assert (line.object_count, line.match.kind) == (2, "Scaled ×0.333")
    assert bpy.ops.shape_google.select_new_object() == {"FINISHED"}
    assert bpy.context.selected_objects == [pear]
    # Only for now.
    assert bpy.ops.shape_google.keep_new_object() == {"FINISHED"}
    assert not len(checked.new_objects)
    assert check(checked) == {}
    bpy.ops.object.select_all(action="DESELECT")
    pear.select_set(True)
    other.select_set(True)
    checked.check_which = "SELECTED"
    assert check(checked) == {"Imported": "Pear"}


def test_only_what_was_checked_is_known_then(checked: Any, addon: ModuleType) -> None:
    pear, late = lumpy("Imported", 1), lumpy("Late", 1)
    bpy.ops.object.select_all(action="DESELECT")
    pear.select_set(True)
    checked.check_which = "SELECTED"
    assert check(checked) == {"Imported": "Pear"}
    checked.check_which = "NEW"
    assert check(checked) == {"Late": "Pear"}
    # What came from the gallery stays known after the next search.
    placed = importlib.import_module(f"{addon.__name__}.state").current().gallery.placed
    placed.add(lumpy("Appended", 1).session_uid)
    late.select_set(True)
    bpy.context.view_layer.objects.active = late
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert not placed
    assert check(checked) == {}


def test_it_is_remembered_that_both_are_kept(checked: Any) -> None:
    pear = lumpy("Imported", 1)
    assert check(checked) == {"Imported": "Pear"}
    assert bpy.ops.shape_google.keep_new_object(remember=True) == {"FINISHED"}
    pear.location = 5, 5, 5  # wherever it is
    bpy.context.view_layer.update()
    checked.check_which = "NOT_INDEXED"
    assert "Imported" not in check(checked)
    (line,) = checked.decisions
    assert line.name == "Keep both Imported and Pear"
    bpy.ops.shape_google.undo_decisions()
    assert "Imported" in check(checked)
    assert not bpy.ops.shape_google.cancel_check.poll()


def test_the_library_s_mesh_takes_its_place(checked: Any) -> None:
    pear = lumpy("Imported", 1)
    pear.data.materials.append(bpy.data.materials.new("Wood"))
    twin = add("Twin", pear.data)
    pear.scale = 0.5, 0.5, 0.5
    bpy.context.view_layer.update()
    before, old = in_world(pear), pear.data
    check(checked)
    assert bpy.ops.shape_google.replace_new_object() == {"FINISHED"}
    assert pear.data == twin.data != old
    assert old.use_fake_user
    assert farthest(in_world(pear), before) < 1e-3
    assert np.allclose(pear.scale, 0.5)


def test_objects_of_this_file_in_the_library_are_no_news(checked: Any, preferences: Any) -> None:
    preferences.use_scene = True
    bpy.ops.shape_google.index_library()
    checked.check_which = "NOT_INDEXED"
    lumpy("Later", 7)  # as "Mine", which is of this file: that is for the panel Duplicates
    assert check(checked) == {}
    assert checked.check_status.startswith("0 of 1 meshes are")
    bpy.data.objects.remove(bpy.data.objects["Later"])
    assert not bpy.ops.shape_google.keep_new_object.poll()
