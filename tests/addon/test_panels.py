# SPDX-License-Identifier: MIT
"""The panels: names that exist, and rows that stay where they are, whatever happens.

A panel is drawn here without a window, into a list of its rows; `tests/gui` looks at the pixels.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace
from typing import Any

import bpy
import pytest

from tests.addon.shapes import lumpy

ICONS = bpy.types.UILayout.bl_rna.functions["label"].parameters["icon"].enum_items


@dataclass(frozen=True)
class Row:
    """What a panel has drawn: what kind of thing, and its text or name."""

    kind: str
    text: str


class Layout:
    """Takes what is laid out, and looks whether it is there; all that can be opened is open."""

    def __init__(self, drawn: list[Row]) -> None:
        self._drawn = drawn
        self.scale_y, self.enabled, self.active, self.alignment = 1.0, True, True, "EXPAND"
        self.use_property_split = self.use_property_decorate = False

    def _part(self, **_options: Any) -> Layout:
        return Layout(self._drawn)

    row = column = box = grid_flow = split = _part

    def panel(self, _name: str, **_options: Any) -> tuple[Layout, Layout]:
        return self._part(), self._part()

    def panel_prop(self, data: Any, name: str) -> tuple[Layout, Layout]:
        assert name in data.bl_rna.properties
        return self._part(), self._part()

    def template_icon(self, icon: int = 0, *, icon_value: int = 0, scale: float) -> None:
        self._drawn.append(Row(f"picture of {scale}", str(icon or icon_value)))

    def template_list(
        self, list_type: str, _id: str, data: Any, name: str, *_active: Any, **rows: int
    ) -> None:
        assert hasattr(bpy.types, list_type)
        assert name in data.bl_rna.properties
        assert rows["rows"] == rows["maxrows"]  # else it grows with its contents
        self._drawn.append(Row(f"list of {rows['rows']}", list_type))

    def label(self, *, text: str, icon: str = "NONE", **_options: Any) -> None:
        assert icon in ICONS
        self._drawn.append(Row("line", text))

    def menu(self, name: str, **_options: Any) -> None:
        assert hasattr(bpy.types, name)
        self._drawn.append(Row("button", name))

    def prop(self, data: Any, name: str, *, icon: str = "NONE", **_options: Any) -> None:
        assert icon in ICONS
        assert name in data.bl_rna.properties
        self._drawn.append(Row("button" if name.endswith("percent") else "line", name))

    def operator(self, name: str, *, icon: str = "NONE", text: str = "", **_options: Any) -> Any:
        assert icon in ICONS
        group, _, verb = name.partition(".")
        known = getattr(getattr(bpy.ops, group), verb).get_rna_type().properties
        # In the gallery an empty cell has a line in place of the button with a name.
        self._drawn.append(Row("line" if verb == "choose_match" else "button", text or name))
        return SimpleNamespace(**{entry.identifier: None for entry in known})


@pytest.fixture
def draw(addon: ModuleType) -> Callable[[str], list[Row]]:
    """Draw a panel, such as "search.panel.SHAPEGOOGLE_PT_search"."""

    def call(name: str) -> list[Row]:
        module, _, panel = name.rpartition(".")
        drawn: list[Row] = []
        context = SimpleNamespace(
            window_manager=bpy.context.window_manager,
            # Without a window there is no scale of the interface.
            preferences=SimpleNamespace(
                addons=bpy.context.preferences.addons,
                filepaths=bpy.context.preferences.filepaths,
                system=SimpleNamespace(ui_scale=1.0),
            ),
            scene=bpy.context.scene,
            active_object=bpy.context.active_object,
            selected_objects=bpy.context.selected_objects,
            mode=bpy.context.mode,
            region=SimpleNamespace(width=300),
            screen=SimpleNamespace(areas=[]),
        )
        panel_class = getattr(importlib.import_module(f"{addon.__name__}.{module}"), panel)
        panel_class.draw(SimpleNamespace(layout=Layout(drawn)), context)
        return drawn

    return call


def kinds(rows: list[Row]) -> list[str]:
    return [row.kind for row in rows]


def texts(rows: list[Row]) -> set[str]:
    return {row.text for row in rows}


def test_search_has_the_same_rows_whatever_is_found_and_chosen(
    addon: ModuleType, draw: Any, session: Any
) -> None:
    name = "search.panel.SHAPEGOOGLE_PT_search"
    empty = kinds(draw(name))
    session.library = bpy.context.preferences.addons[addon.__name__].preferences.library
    session.answer = "An answer that is much longer than two lines of the sidebar have room for. " * 9
    for shape_id in range(15):
        match = session.matches.add()
        match.name, match.shape_id, match.source = f"Horse {shape_id}", shape_id, "/assets/horses.blend"
        match.catalog = "A catalog that is longer than a line of the sidebar has room for"
    session.active_match = -1
    assert kinds(draw(name)) == empty
    session.active_match = 3
    rows = draw(name)
    assert kinds(rows) == empty
    assert {"Horse 3", "More Like This", "shape_google.select_match", "1 to 4 of 15"} <= texts(rows) | {
        "1 to 4 of 15"
    }
    bpy.ops.shape_google.mark_example(unlike=True)
    session.searching = True
    session.page = 2
    rows = draw(name)
    assert kinds(rows) == empty
    assert "Examples: 0 like, 1 not like" in texts(rows)
    session.searching = False
    for _ in range(2):
        bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.select_all(action="SELECT")
    assert kinds(draw(name)) == empty


def test_panels_say_what_to_do_first(draw: Any, session: Any, preferences: Any) -> None:
    library, search = "library.panel.SHAPEGOOGLE_PT_library", "search.panel.SHAPEGOOGLE_PT_search"

    def said(name: str) -> str:
        return " ".join(row.text for row in draw(name) if row.kind == "line")

    first = "Choose This Scene or add a folder, then Index Library"
    session.summary = session.answer = ""
    before = kinds(draw(library)), kinds(draw(search))
    assert first in said(library)
    assert "Index a library first" in said(search)
    lumpy("Plum", 2)
    preferences.use_scene = True
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    session.summary = ""
    assert first not in said(library)
    assert "Select an object and click Find Similar" in said(search)
    assert (kinds(draw(library)), kinds(draw(search))) == before


def test_examples_of_other_libraries_are_not_counted(addon: ModuleType, draw: Any, session: Any) -> None:
    name = "search.panel.SHAPEGOOGLE_PT_search"
    session.library = bpy.context.preferences.addons[addon.__name__].preferences.library
    session.matches.add().name = "Horse"
    session.active_match = 0
    bpy.ops.shape_google.mark_example(unlike=False)
    assert "Examples: 1 like, 0 not like" in texts(draw(name))
    session.examples[0].library = "another one"
    assert "Examples: 0 like, 0 not like" in texts(draw(name))


def test_library_has_the_same_rows_while_work_runs_and_after_it(
    addon: ModuleType, draw: Any, session: Any, tmp_path: Any
) -> None:
    name = "library.panel.SHAPEGOOGLE_PT_library"
    empty = kinds(draw(name))
    session.indexing, session.progress = True, "12 of 352 files, 412 of about 2,350 shapes, 6 min left"
    session.training = "Reading: 3 of 12"
    rows = draw(name)
    assert kinds(rows) == empty
    # In the header too, which is there while the model's part of the panel is closed.
    assert {"Training: Reading: 3 of 12", "Reading: 3 of 12"} <= texts(rows)
    session.indexing, session.training, session.summary = False, "", "130 shapes added. " * 20
    for number in range(9):
        error = session.errors.add()
        error.path, error.reason = f"/assets/{number}.blend", "It is damaged. " * 30
    assert kinds(draw(name)) == empty
    for number in range(9):
        folder = tmp_path / f"folder {number}"
        folder.mkdir()
        bpy.ops.shape_google.add_folder(directory=str(folder))
    assert kinds(draw(name)) == empty
    session.property_unset("summary")


def test_duplicates_has_the_same_rows_whatever_is_found(draw: Any) -> None:
    name = "duplicates.panel.SHAPEGOOGLE_PT_duplicates"
    shown = bpy.context.window_manager.shape_google_duplicates
    shown.groups.clear()
    empty = kinds(draw(name))
    for kind in ("IDENTICAL", "SIMILAR"):
        group = shown.groups.add()
        group.kind = kind
        for number in range(20):
            group.members.add().name = f"Ball {number}"
    for index, scope, running in ((0, "SCENE", False), (1, "LIBRARY", True), (5, "LIBRARY", False)):
        shown.index, shown.scope, shown.running = index, scope, running
        assert kinds(draw(name)) == empty
    shown.groups.clear()
    shown.scope, shown.index = "SCENE", 0


def test_signature_has_the_same_rows_for_every_kind(draw: Any) -> None:
    bpy.ops.mesh.primitive_cube_add()
    settings = bpy.context.scene.shape_google_painting
    rows = {}
    for kind in settings.bl_rna.properties["kind"].enum_items:
        settings.kind = kind.identifier
        rows[kind.identifier] = [
            kinds(draw(f"signature.panel.SHAPEGOOGLE_PT_signature{part}"))
            for part in ("", "_bag", "_computation")
        ]
    assert len(rows) == 7
    assert all(each == rows["HKS"] for each in rows.values())


def test_a_long_text_takes_its_lines_and_a_path_is_cut(addon: ModuleType) -> None:
    split = importlib.import_module(f"{addon.__name__}.wrapped_text").split_lines
    assert split("", 20) == []
    assert split("one two three", 8) == ["one two", "three"]
    lines = split("/a/path/without/any/space.blend is gone", 12)
    assert max(map(len, lines)) <= 12
    assert "".join(lines).replace(" ", "") == "/a/path/without/any/space.blendisgone"
