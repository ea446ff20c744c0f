# SPDX-License-Identifier: MIT
"""The list of groups follows linking, undo, and objects that are deleted or renamed."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import bpy
import pytest


@pytest.fixture
def shown(blender: Any) -> Any:
    """The groups of a scene of three balls and two tori, each with its own mesh."""
    bpy.ops.mesh.primitive_torus_add()
    bpy.context.object.name = "Ring"
    bpy.ops.mesh.primitive_torus_add(location=(4, 0, 0))
    for number in range(3):
        bpy.ops.mesh.primitive_uv_sphere_add(location=(0, 4 * number, 4))
        bpy.context.object.name = f"Ball {number}"
    bpy.context.window_manager.shape_google_duplicates.similar = False
    bpy.ops.shape_google.find_duplicates()
    bpy.ops.ed.undo_push(message="found")
    return bpy.context.window_manager.shape_google_duplicates


def listed(shown: Any) -> dict[str, int]:
    return {group.name: group.meshes for group in shown.groups}


def test_linking_is_undone_and_the_group_comes_back(shown: Any) -> None:
    assert listed(shown) == {"Ball 0": 3, "Ring": 2}
    saving = {group.name: group.saved_megabytes for group in shown.groups}
    next(group for group in shown.groups if group.name == "Ball 0").chosen = True
    assert bpy.ops.shape_google.link_duplicates() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="linked")
    assert listed(shown) == {"Ring": 2}
    bpy.ops.ed.undo()
    shown = bpy.context.window_manager.shape_google_duplicates
    assert listed(shown) == {"Ball 0": 3, "Ring": 2}
    assert {group.name: group.saved_megabytes for group in shown.groups} == saving
    bpy.ops.ed.redo()
    assert listed(bpy.context.window_manager.shape_google_duplicates) == {"Ring": 2}


def test_objects_are_deleted_and_renamed(addon: ModuleType, shown: Any) -> None:
    refresh = importlib.import_module(f"{addon.__name__}.duplicates.follow").refresh_groups
    bpy.data.objects["Ball 0"].name = "Moon"
    refresh(bpy.context)
    assert listed(shown) == {"Moon": 3, "Ring": 2}
    bpy.data.objects.remove(bpy.data.objects["Ball 1"])
    bpy.data.objects.remove(bpy.data.objects["Ring"])
    refresh(bpy.context)
    assert listed(shown) == {"Moon": 2}
    assert shown.status.startswith("1 group in this scene")
    assert bpy.ops.shape_google.select_duplicates(index=0) == {"FINISHED"}
    assert {item.name for item in bpy.context.selected_objects} == {"Moon", "Ball 2"}
