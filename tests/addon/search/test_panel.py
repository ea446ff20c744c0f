# SPDX-License-Identifier: MIT
"""The panel Search names only operators, properties and icons that there are; to see it takes a window."""

from __future__ import annotations

import importlib
from types import ModuleType, SimpleNamespace
from typing import Any

import bpy
import pytest

ICONS = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items


class Layout:
    """Takes what is laid out, and looks whether it is there."""

    def __init__(self, drawn: list[str]) -> None:
        self._drawn = drawn
        self.scale_y, self.enabled, self.alignment = 1.0, True, "EXPAND"
        self.use_property_split = self.use_property_decorate = False

    def _part(self, **_options: Any) -> Layout:
        return Layout(self._drawn)

    row = column = box = grid_flow = _part

    def panel(self, _name: str, **_options: Any) -> tuple[Layout, Layout]:
        return self._part(), self._part()

    def template_icon(self, **_options: Any) -> None:
        self._drawn.append("picture")

    def template_list(
        self, list_type: str, _id: str, data: Any, name: str, *_active: Any, **_rows: Any
    ) -> None:
        assert hasattr(bpy.types, list_type)
        assert name in data.bl_rna.properties
        self._drawn.append(list_type)

    def label(self, *, text: str, icon: str = "NONE") -> None:
        assert icon in ICONS
        self._drawn.append(text)

    def prop(self, data: Any, name: str, *, icon: str = "NONE", **_options: Any) -> None:
        assert icon in ICONS
        assert name in data.bl_rna.properties
        self._drawn.append(name)

    def operator(self, name: str, *, icon: str = "NONE", text: str = "", **_options: Any) -> Any:
        assert icon in ICONS
        group, _, verb = name.partition(".")
        known = getattr(getattr(bpy.ops, group), verb).get_rna_type().properties
        self._drawn.append(text or name)
        return SimpleNamespace(**{entry.identifier: None for entry in known})


@pytest.fixture
def draw(addon: ModuleType) -> Any:
    """Draw the panel; the texts and names in it."""
    module = importlib.import_module(f"{addon.__name__}.search.panel")

    def call() -> list[str]:
        drawn: list[str] = []
        context = SimpleNamespace(
            window_manager=bpy.context.window_manager,
            # Without a window there is no scale of the interface.
            preferences=SimpleNamespace(
                addons=bpy.context.preferences.addons, system=SimpleNamespace(ui_scale=1.0)
            ),
            selected_objects=bpy.context.selected_objects,
            mode=bpy.context.mode,
            region=SimpleNamespace(width=300),
        )
        module.SHAPEGOOGLE_PT_search.draw(SimpleNamespace(layout=Layout(drawn)), context)
        return drawn

    return call


def test_the_choice_for_several_objects_is_shown_where_there_are_several(draw: Any) -> None:
    bpy.ops.mesh.primitive_cube_add()
    assert "several" not in draw()
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.select_all(action="SELECT")
    assert "several" in draw()
    bpy.ops.object.mode_set(mode="EDIT")
    assert "several" not in draw()


def test_examples_are_listed_and_a_match_can_become_one(addon: ModuleType, draw: Any) -> None:
    session = bpy.context.window_manager.shape_google
    library = bpy.context.preferences.addons[addon.__name__].preferences.library
    assert "Examples from the Library" not in draw()
    match = session.matches.add()
    match.name, match.shape_id, session.library = "Horse", 3, library
    session.active_match = 0
    assert {"More Like This", "Not Like This"} <= set(draw())
    bpy.ops.shape_google.mark_example(unlike=True)
    assert {"Examples from the Library", "Not like Horse", "shape_google.remove_example"} <= set(draw())
    bpy.ops.shape_google.mark_example(unlike=False)
    assert "Like Horse" in draw()
    session.examples[0].library = "another one"
    assert "Like Horse" not in draw()
