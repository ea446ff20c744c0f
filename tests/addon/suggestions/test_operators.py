# SPDX-License-Identifier: MIT
"""Suggested tags and catalogs: shown with their confidence, written as chosen, undone."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import bpy
import pytest

from tests.addon.shapes import lumpy

CATALOG = "3f4bd4d3-2f6c-4a4e-9f0e-2b1f6d5f8a11"


@pytest.fixture
def tagged(tmp_path: Path, preferences: Any) -> Path:
    """An asset library whose pears are tagged, and one that is not."""
    path = tmp_path / "assets" / "fruit.blend"
    path.parent.mkdir()
    (path.parent / "blender_assets.cats.txt").write_text(f"VERSION 1\n\n{CATALOG}:Food/Fruit:Food-Fruit\n")
    for number in range(3):
        item = lumpy(f"Pear {number}", 0)
        item.scale = 1 + number / 10, 1, 1
        item.asset_mark()
        item.asset_data.tags.new("pear")
        item.asset_data.catalog_id = CATALOG
    lumpy("New pear", 0).scale = 1.05, 1.05, 1
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    preferences.use_scene = True
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    return path


def test_suggestions_are_written_as_chosen(
    tagged: Path, addon: ModuleType, session: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    item = bpy.data.objects["New pear"]
    bpy.context.view_layer.objects.active = item
    assert bpy.ops.shape_google.suggest_tags() == {"FINISHED"}
    found = {(line.kind, line.text): line for line in session.suggestions}
    assert set(found) == {("tag", "pear"), ("catalog", "Food/Fruit")}
    assert all(line.use and line.confidence >= 0.5 for line in found.values())
    assert "Pear" in found["tag", "pear"].relatives
    found["catalog", "Food/Fruit"].use = False
    assert bpy.ops.shape_google.write_suggestions() == {"FINISHED"}
    assert [tag.name for tag in item.asset_data.tags] == ["pear"]
    assert item.asset_data.catalog_simple_name == ""
    # What it has is not suggested again.
    assert bpy.ops.shape_google.suggest_tags() == {"FINISHED"}
    assert [(line.kind, line.text) for line in session.suggestions] == [("catalog", "Food/Fruit")]
    session.suggestions[0].use = False
    assert bpy.ops.shape_google.write_suggestions() == {"CANCELLED"}
    assert "nothing is written" in capfd.readouterr().out
    session.suggestions[0].use = True
    assert bpy.ops.shape_google.write_suggestions() == {"FINISHED"}
    assert item.asset_data.catalog_id == CATALOG
    operators = importlib.import_module(f"{addon.__name__}.suggestions.operators")
    assert operators.known_catalogs() == {"Food/Fruit": CATALOG}
    assert "UNDO" in operators.SHAPEGOOGLE_OT_write_suggestions.bl_options
    bpy.ops.wm.read_homefile(use_empty=True)


def test_where_nothing_can_be_suggested_there_is_nothing_to_confirm(addon: ModuleType, session: Any) -> None:
    session.suggestions.clear()
    session.suggested_for = lumpy("Pear", 0).session_uid
    shown: list[str] = []

    def popup_menu(draw: Any, *, title: str, icon: str) -> None:
        label = SimpleNamespace(label=lambda *, text, translate: shown.append(text))
        shown.append(title)
        draw(SimpleNamespace(layout=label), context)

    manager = SimpleNamespace(popup_menu=popup_menu, shape_google=session)
    context = SimpleNamespace(window_manager=manager)
    operators = importlib.import_module(f"{addon.__name__}.suggestions.operators")
    write = operators.SHAPEGOOGLE_OT_write_suggestions
    assert write.invoke(SimpleNamespace(), context, None) == {"CANCELLED"}
    assert shown == [
        "Nothing to Suggest",
        "The nearest shapes have no further tags or catalogs.",
        "Tag some assets, index them, and try again.",
    ]
