# SPDX-License-Identifier: MIT
"""Painting shows at once, can be undone and cleared, and is offered where it is possible."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest

from shapegoogle_core.rendering import word_palette
from tests.addon.signature.objects import add_blob, own_names, paint


class TestShowing:
    def test_colours_are_active_and_rendered(self) -> None:
        item = add_blob()
        paint("HKS")
        assert item.data.attributes.active_color_name == "sg_color"
        assert item.data.attributes.default_color_name == "sg_color"
        attribute = item.data.attributes["sg_color"]
        assert (attribute.domain, attribute.data_type) == ("POINT", "FLOAT_COLOR")

    def test_no_colour_if_not_wanted(self) -> None:
        item = add_blob()
        paint("HKS", color=False)
        assert own_names(item) == {"sg_hks"}

    def test_slider_repaints_at_once(self, modules: Any, settings: Any) -> None:
        item = add_blob()
        paint("HKS", scale=0.2)
        colors = modules.attributes.values_of(item.data, "sg_color")
        settings.scale = 0.8
        moved = modules.attributes.values_of(item.data, "sg_hks")
        assert not np.array_equal(modules.attributes.values_of(item.data, "sg_color"), colors)
        paint("HKS", scale=0.8)
        assert np.array_equal(modules.attributes.values_of(item.data, "sg_hks"), moved)

    def test_slider_leaves_unpainted_and_changed_objects_alone(self, modules: Any, settings: Any) -> None:
        item = add_blob()
        settings.scale = 0.7
        assert not own_names(item)
        paint("HKS", scale=0.2)
        before = modules.attributes.values_of(item.data, "sg_hks")
        item.data.vertices[0].co.x += 1
        settings.scale = 0.8
        assert np.array_equal(modules.attributes.values_of(item.data, "sg_hks"), before)

    def test_scale_is_said_in_the_units_of_the_scene(self, modules: Any) -> None:
        item = add_blob()
        paint("HKS")
        units = bpy.context.scene.unit_settings
        painting = modules.properties.settings_of(bpy.context.scene)
        text = modules.distance.scale_text(item, painting, units)
        assert " m · " in text or "cm · " in text
        assert text.endswith(" % of its size")
        units.system = "NONE"
        assert modules.distance.scale_text(item, painting, units).split(" ")[0].replace(".", "").isdigit()
        units.system = "METRIC"
        other = bpy.data.objects.new("Other", item.data)
        assert modules.distance.scale_text(other, painting, units) == ""

    def test_chart_has_a_bar_for_each_frequent_word(self, modules: Any) -> None:
        bag = np.zeros(40)
        bag[[3, 20]] = 0.25, 0.75
        pixels = np.asarray(modules.bag_chart.draw_chart(bag))
        assert pixels.shape[0] == pixels.shape[1]
        palette = np.round(255 * word_palette(40)).astype(int)
        heights = [
            int((pixels[:, :, :3] == palette[word]).all(axis=2).any(axis=1).sum()) for word in range(40)
        ]
        assert heights[20] == pytest.approx(3 * heights[3], abs=3)
        assert sum(height > 0 for height in heights) == 2


class TestUndoAndClear:
    def test_undo_removes_what_was_written(self) -> None:
        add_blob()
        bpy.ops.ed.undo_push(message="blob")
        paint("HKS")
        assert own_names(bpy.data.objects["Blob"]) == {"sg_hks", "sg_color"}
        bpy.ops.ed.undo_push(message="painted")
        bpy.ops.ed.undo()
        assert not own_names(bpy.data.objects["Blob"])
        bpy.ops.ed.redo()
        assert own_names(bpy.data.objects["Blob"]) == {"sg_hks", "sg_color"}

    def test_undo_brings_slider_and_values_back(self, modules: Any) -> None:
        add_blob()
        paint("HKS", scale=0.2)
        before = modules.attributes.values_of(bpy.data.objects["Blob"].data, "sg_hks")
        bpy.ops.ed.undo_push(message="painted")
        bpy.context.scene.shape_google_painting.scale = 0.9
        bpy.ops.ed.undo_push(message="slider")
        bpy.ops.ed.undo()
        assert bpy.context.scene.shape_google_painting.scale == pytest.approx(0.2)
        assert np.array_equal(modules.attributes.values_of(bpy.data.objects["Blob"].data, "sg_hks"), before)

    def test_clear_removes_ours_and_nothing_else(self) -> None:
        item = add_blob()
        for name, kind in (("mine", "FLOAT_COLOR"), ("weight", "FLOAT"), ("my_sg_hks", "FLOAT")):
            item.data.attributes.new(name, kind, "POINT")
        item.data.attributes.active_color_name = "mine"
        item.data.attributes.default_color_name = "mine"
        item.data["note"] = "keep"
        before = [(attribute.name, attribute.data_type) for attribute in item.data.attributes]
        for kind in ("HKS", "HKS_TIMES", "SI_HKS", "WORDS", "RGB", "HEAT", "KEYPOINTS"):
            paint(kind, keep=True)
        assert len(own_names(item)) > 15
        assert bpy.ops.shape_google.clear_paint() == {"FINISHED"}
        assert [(attribute.name, attribute.data_type) for attribute in item.data.attributes] == before
        assert item.data.attributes.active_color_name == "mine"
        assert item.data.attributes.default_color_name == "mine"
        assert dict(item.data.items()) == {"note": "keep"}
        assert bpy.ops.shape_google.clear_paint() == {"CANCELLED"}

    def test_an_attribute_of_ours_with_another_type_is_replaced(self, modules: Any) -> None:
        item = add_blob()
        item.data.attributes.new("sg_hks", "INT", "FACE")
        paint("HKS")
        assert len(modules.attributes.values_of(item.data, "sg_hks")) == len(item.data.vertices)

    def test_edit_mode(self, modules: Any) -> None:
        item = add_blob()
        paint("HKS", scale=0.3)
        values = modules.attributes.values_of(item.data, "sg_hks")
        bpy.ops.shape_google.clear_paint()
        bpy.ops.object.mode_set(mode="EDIT")
        assert paint("HKS") == {"FINISHED"}
        assert paint("WORDS", keep=True) == {"FINISHED"}
        assert item.mode == "EDIT"
        bpy.ops.object.mode_set(mode="OBJECT")
        assert np.array_equal(modules.attributes.values_of(item.data, "sg_hks"), values)
        word = modules.attributes.values_of(item.data, "sg_word")
        assert item.data.attributes.active_color_name == "sg_color"
        palette = modules.layers.linear_rgb(word_palette(40))
        colors = modules.attributes.values_of(item.data, "sg_color")
        assert np.allclose(colors[:, :3], palette[word], atol=1e-6)
        bpy.ops.object.mode_set(mode="EDIT")
        assert bpy.ops.shape_google.clear_paint() == {"FINISHED"}
        bpy.ops.object.mode_set(mode="OBJECT")
        assert not own_names(item)


class TestPoll:
    def test_needs_a_mesh(self) -> None:
        assert not bpy.ops.shape_google.paint.poll()
        add_blob()
        assert bpy.ops.shape_google.paint.poll()
        bpy.ops.object.mode_set(mode="SCULPT")
        assert not bpy.ops.shape_google.paint.poll()
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_objects_that_are_not_evaluated_are_refused(self, modules: Any) -> None:
        """Their scale is not known; another object of the same mesh is painted in their place."""
        item = add_blob()
        twin = bpy.data.objects.new("Twin", item.data)
        bpy.context.collection.objects.link(twin)
        twin.hide_viewport = True
        items, refused = modules.painting.targets([twin, item])
        assert items == [item]
        assert [reason for reason in refused if "'Twin' is disabled" in reason]

    def test_objects_that_share_a_mesh_are_painted_once(self, modules: Any) -> None:
        item = add_blob()
        twin = bpy.data.objects.new("Twin", item.data)
        bpy.context.collection.objects.link(twin)
        twin.select_set(True)
        items, refused = modules.painting.targets(bpy.context.selected_objects)
        assert len(items) == 1
        assert not refused
