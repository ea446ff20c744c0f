# SPDX-License-Identifier: MIT
"""Selecting groups, and the duplicates of a library."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import bpy
import pytest

from tests.addon.duplicates.objects import add, find, lump, module, motion


@pytest.fixture
def preferences(addon: ModuleType) -> Iterator[Any]:
    """The add-on's preferences; the library is put back afterwards."""
    chosen = bpy.context.preferences.addons[addon.__name__].preferences
    before = chosen.library
    yield chosen
    chosen.library = before


def test_select_takes_the_group_and_nothing_else(shown: Any) -> None:
    data = lump()
    a, b, other = add("a", data), add("b", data.copy(), motion(1)), add("other", lump(seed=3))
    other.select_set(True)
    find(shown)
    assert bpy.ops.shape_google.select_duplicates(index=0) == {"FINISHED"}
    assert set(bpy.context.selected_objects) == {a, b}
    assert bpy.context.view_layer.objects.active.name == shown.groups[0].name
    with pytest.raises(RuntimeError, match="no group 7"):
        bpy.ops.shape_google.select_duplicates(index=7)


def test_a_library_is_listed_and_its_shapes_here_can_be_selected(
    addon: ModuleType, shown: Any, tmp_path: Path, preferences: Any
) -> None:
    from shapegoogle_core import Library

    scene = module(addon, "scene.meshes")
    blend = tmp_path / "scene.blend"
    first = add("a", lump())
    second = add("b", lump())
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    path = tmp_path / "shapes.sglib"
    with Library.open(path) as library:
        for item in (first, second):
            library.add(scene.base_mesh(item), source=str(blend), object_name=item.name)
    preferences.library = str(path)
    shown.scope = "LIBRARY"
    assert find(shown) == {"IDENTICAL": ["a", "b"]}
    assert not shown.groups[0].linkable
    assert bpy.ops.shape_google.select_duplicates() == {"FINISHED"}
    assert set(bpy.context.selected_objects) == {first, second}


def test_a_shape_of_a_library_is_listed_by_a_name_that_says_something(
    addon: ModuleType, shown: Any, tmp_path: Path, preferences: Any
) -> None:
    """Of twenty bottles each is called "Cylinder.001" in its file."""
    from shapegoogle_core import Library

    scene = module(addon, "scene.meshes")
    item = add("Cylinder.001", lump())
    path = tmp_path / "shapes.sglib"
    with Library.open(path) as library:
        for name in ("Full", "Empty"):
            source = str(tmp_path / f"{name}.blend")
            library.add(scene.base_mesh(item), name=name, source=source, object_name=item.name)
    preferences.library = str(path)
    shown.scope = "LIBRARY"
    find(shown)
    [group] = shown.groups
    assert {member.title for member in group.members} == {"Full", "Empty"}
    assert group.name == group.members[0].title
    # By this name it is found in its file.
    assert {member.name for member in group.members} == {"Cylinder.001"}
    operators = module(addon, "decisions.operators")
    decide = operators.SHAPEGOOGLE_OT_decide_duplicate
    [_], [], sentence = decide._plan(SimpleNamespace(kind="MASTER"), bpy.context)
    assert sentence == f"{group.name} is the master among its duplicates"


def test_without_a_usable_library_it_says_so(
    addon: ModuleType, shown: Any, tmp_path: Path, preferences: Any
) -> None:
    shown.scope = "LIBRARY"
    preferences.library = str(tmp_path / "none.sglib")
    with pytest.raises(RuntimeError, match="Index a library first"):
        bpy.ops.shape_google.find_duplicates()
    broken = tmp_path / "broken.sglib"
    broken.write_text("no library")
    preferences.library = str(broken)
    with pytest.raises(RuntimeError, match=r"broken\.sglib"):
        bpy.ops.shape_google.find_duplicates()
