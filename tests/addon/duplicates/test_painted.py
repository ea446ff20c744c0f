# SPDX-License-Identifier: MIT
"""Painted attributes make no difference between duplicates."""

from __future__ import annotations

from typing import Any

import bpy

from tests.addon.shapes import lumpy


def test_paint_is_no_difference_and_library_groups_are_selected(preferences: Any, session: Any) -> None:
    first = lumpy("First", 0)
    second = first.copy()
    second.data = first.data.copy()
    second.name = "Second"
    bpy.context.collection.objects.link(second)
    preferences.use_scene = True
    bpy.ops.shape_google.index_library()
    first.select_set(True)
    bpy.context.scene.shape_google_painting.kind = "WORDS"
    bpy.ops.shape_google.paint()
    state = bpy.context.window_manager.shape_google_duplicates
    state.scope = "SCENE"
    bpy.ops.shape_google.find_duplicates()
    assert [(group.kind, group.linkable) for group in state.groups] == [("IDENTICAL", True)]
    state.scope = "LIBRARY"
    bpy.ops.shape_google.find_duplicates()
    bpy.ops.object.select_all(action="DESELECT")
    assert bpy.ops.shape_google.select_duplicates(index=0) == {"FINISHED"}
    assert {item.name for item in bpy.context.selected_objects} == {"First", "Second"}
    state.scope = "SCENE"
