# SPDX-License-Identifier: MIT
"""Clearing and undo restore what was shown before; painting leaves nothing of other kinds unless asked to."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
import pytest

from tests.addon.signature.objects import add_blob, own_names, paint


@pytest.fixture
def view() -> Iterator[Any]:
    """A 3D view in rendered shading, which is the one that buttons are pressed in."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    shading = area.spaces.active.shading
    before = shading.type, shading.color_type
    shading.color_type, shading.type = "OBJECT", "RENDERED"
    with bpy.context.temp_override(window=window, area=area):
        yield area
    shading.type, shading.color_type = before


def shading(view: Any) -> tuple[str, str]:
    chosen = view.spaces.active.shading
    return chosen.type, chosen.color_type


def step(name: str) -> None:
    bpy.ops.ed.undo_push(message=name)


class TestShading:
    def test_clear_restores_it_once_nothing_is_painted(self, view: Any) -> None:
        first, second = add_blob(3, "First"), add_blob(3, "Second")
        first.select_set(True)
        paint("HKS")
        assert shading(view) == ("SOLID", "VERTEX")
        first.select_set(False)
        bpy.ops.shape_google.clear_paint()
        assert own_names(first)
        assert not own_names(second)
        assert shading(view) == ("SOLID", "VERTEX")
        first.select_set(True)
        bpy.ops.shape_google.clear_paint()
        assert shading(view) == ("RENDERED", "OBJECT")
        assert not view.id_data.keys()

    def test_undo_and_redo_take_it_along(self, view: Any) -> None:
        add_blob(3)
        step("blob")
        paint("HKS")
        step("painted")
        bpy.ops.ed.undo()
        assert shading(view) == ("RENDERED", "OBJECT")
        bpy.ops.ed.redo()
        assert shading(view) == ("SOLID", "VERTEX")
        bpy.ops.shape_google.clear_paint()
        step("cleared")
        assert shading(view) == ("RENDERED", "OBJECT")
        bpy.ops.ed.undo()
        assert shading(view) == ("SOLID", "VERTEX")

    def test_it_is_restored_for_another_file_and_stays_for_a_painted_one(
        self, view: Any, tmp_path: Path
    ) -> None:
        """A file that is opened without its own windows keeps the views of the one before."""
        plain, painted = (str(tmp_path / f"{name}.blend") for name in ("plain", "painted"))
        add_blob(3)
        bpy.ops.wm.save_as_mainfile(filepath=plain, copy=True)
        paint("HKS")
        bpy.ops.wm.save_as_mainfile(filepath=painted, copy=True)
        bpy.ops.wm.open_mainfile(filepath=painted, load_ui=False)
        assert shading(view) == ("SOLID", "VERTEX")
        bpy.ops.wm.open_mainfile(filepath=plain, load_ui=False)
        assert shading(view) == ("RENDERED", "OBJECT")
        assert not view.id_data.keys()

    def test_what_the_user_has_chosen_since_stays(self, view: Any) -> None:
        add_blob(3)
        paint("HKS")
        view.spaces.active.shading.color_type = "RANDOM"
        bpy.ops.shape_google.clear_paint()
        assert shading(view) == ("SOLID", "RANDOM")
        assert not view.id_data.keys()


class TestColors:
    @pytest.mark.parametrize("active", ["first", "last"])
    def test_the_active_attribute_and_both_colours_come_back(self, active: str) -> None:
        item = add_blob(3)
        for name in ("first", "middle", "last"):
            item.data.attributes.new(name, "FLOAT_COLOR", "POINT")
        item.data.attributes.active = item.data.attributes[active]
        item.data.attributes.active_color_name = "middle"
        item.data.attributes.default_color_name = "last"
        for kind in ("HKS", "WORDS", "HKS"):
            paint(kind)
            assert item.data.attributes.active.name == active
        assert bpy.ops.shape_google.clear_paint() == {"FINISHED"}
        assert item.data.attributes.active_color_name == "middle"
        assert item.data.attributes.default_color_name == "last"
        assert item.data.attributes.active.name == active

    def test_a_colour_chosen_since_stays(self) -> None:
        item = add_blob(3)
        for name in ("first", "last"):
            item.data.attributes.new(name, "FLOAT_COLOR", "POINT")
        item.data.attributes.active_color_name = item.data.attributes.default_color_name = "first"
        paint("HKS")
        item.data.attributes.active_color_name = "last"
        bpy.ops.shape_google.clear_paint()
        assert item.data.attributes.active_color_name == "last"
        assert item.data.attributes.default_color_name == "first"

    def test_painting_without_colour_takes_an_outdated_one_away(self) -> None:
        item = add_blob(3)
        item.data.attributes.new("mine", "FLOAT_COLOR", "POINT")
        item.data.attributes.active_color_name = "mine"
        paint("HKS")
        paint("RGB", color=False)
        assert own_names(item) == {"sg_hks_1", "sg_hks_2", "sg_hks_3"}
        assert item.data.attributes.active_color_name == "mine"


class TestOtherKinds:
    def test_they_go_unless_they_are_kept(self, settings: Any) -> None:
        item = add_blob(3)
        item.data.attributes.new("sg_of_another_program", "FLOAT", "POINT")
        paint("HKS")
        paint("SI_HKS", frequencies=2)
        others = {"sg_of_another_program", "sg_color"}
        assert own_names(item) == {"sg_sihks_0", "sg_sihks_1"} | others
        paint("RGB", keep=True)
        rgb = {"sg_hks_1", "sg_hks_2", "sg_hks_3"}
        assert own_names(item) == {"sg_sihks_0", "sg_sihks_1"} | rgb | others
        # The slider repaints its own kind alone.
        paint("HKS", keep=True)
        settings.keep = False
        settings.scale = 0.3
        assert own_names(item) == {"sg_hks", "sg_sihks_0", "sg_sihks_1"} | rgb | others


class TestHeat:
    def select(self, item: Any, *vertices: int) -> None:
        item.data.polygons.foreach_set("select", [False] * len(item.data.polygons))
        item.data.edges.foreach_set("select", [False] * len(item.data.edges))
        chosen = [index in vertices for index in range(len(item.data.vertices))]
        item.data.vertices.foreach_set("select", chosen)

    def test_of_two_vertices_it_says_which_one(self, modules: Any, capfd: pytest.CaptureFixture[str]) -> None:
        item = add_blob(3)
        self.select(item, 7, 21)
        paint("HEAT")
        assert "Painted 'Blob' from vertex 7, the first one of 2 selected, at " in capfd.readouterr().out
        text = modules.picked.picked_text
        assert text(item) == "From the vertex selected in edit mode"
        bpy.ops.object.mode_set(mode="EDIT")
        assert text(item) == "From the first of 2 selected vertices"
        import bmesh

        edited = bmesh.from_edit_mesh(item.data)
        edited.verts.ensure_lookup_table()
        edited.select_history.add(edited.verts[21])
        assert text(item) == "From vertex 21, the active one of 2 selected"
        paint("HEAT")
        assert "from vertex 21, the active one of 2 selected, at " in capfd.readouterr().out
        bpy.ops.mesh.select_all(action="DESELECT")
        assert text(item) == "Select the vertex it spreads from"
        with pytest.raises(RuntimeError, match="in edit mode, select the one that heat spreads from"):
            paint("HEAT")
