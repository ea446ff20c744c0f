# SPDX-License-Identifier: MIT
"""Keypoints that are painted equal those of the core, and can be selected."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
import pytest

import shapegoogle_core as sg
from shapegoogle_core.keypoints import DETECTORS
from tests.addon.signature.objects import add_blob, add_creature, own_names, paint, selected_vertices


class TestKeypoints:
    @pytest.mark.parametrize("detector", DETECTORS)
    def test_are_those_of_the_core(self, modules: Any, detector: str) -> None:
        item = add_creature()
        assert paint("KEYPOINTS", detector=detector, eigenpairs=60) == {"FINISHED"}
        mesh = modules.scene.base_mesh(item)
        expected = sg.detect_keypoints(mesh, sg.compute_spectrum(mesh, 60), detector)
        response = modules.attributes.values_of(item.data, "sg_keypoint")
        assert len(expected) > 3
        assert set(np.flatnonzero(response)) == set(expected.indices)
        assert np.allclose(response[expected.indices], expected.response)

    def test_choices_are_those_of_the_core(self, modules: Any) -> None:
        assert [name for name, _, _ in modules.choices.DETECTORS] == list(DETECTORS)

    def test_spots_are_seen_and_the_strongest_is_reddest(self, modules: Any) -> None:
        item = add_creature()
        paint("KEYPOINTS")
        response = modules.attributes.values_of(item.data, "sg_keypoint")
        colors = modules.attributes.values_of(item.data, "sg_color")[:, :3]
        surface = modules.layers.linear_rgb(np.array(modules.layers.NO_POINT))
        plain = np.isclose(colors, surface, atol=1e-5).all(axis=1)
        assert 0.8 < plain.mean() < 0.99
        assert not plain[response > 0].any()
        strongest = modules.layers.linear_rgb(np.array(modules.layers.STRONG_POINT))
        assert np.allclose(colors[response.argmax()], strongest, atol=1e-5)

    def test_are_selected_in_edit_mode(self, modules: Any) -> None:
        item, plain = add_creature(), add_blob()
        item.select_set(True)
        plain.select_set(False)
        paint("KEYPOINTS")
        points = np.flatnonzero(modules.attributes.values_of(item.data, "sg_keypoint"))
        # The active object, which is selected too, has no keypoints: nothing of it is selected.
        plain.select_set(True)
        assert bpy.ops.shape_google.select_keypoints() == {"FINISHED"}
        assert item.mode == "EDIT"
        assert tuple(bpy.context.scene.tool_settings.mesh_select_mode) == (True, False, False)
        # Nothing has asked for `context.tool_settings`, which crashes Blender 4.2 and 4.3 later on.
        assert bpy.context.id_data is None
        bpy.ops.mesh.select_all(action="SELECT")
        assert bpy.ops.shape_google.select_keypoints() == {"FINISHED"}  # again, in edit mode
        for each, expected in ((item, points), (plain, [])):
            each.update_from_editmode()
            assert np.array_equal(selected_vertices(each), expected)

    def test_undo_leaves_edit_mode(self) -> None:
        item = add_creature()
        paint("KEYPOINTS")
        before = selected_vertices(item)
        bpy.ops.ed.undo_push(message="painted")
        bpy.ops.shape_google.select_keypoints()
        bpy.ops.ed.undo_push(message="selected")
        bpy.ops.ed.undo()
        item = bpy.data.objects["Creature"]
        assert item.mode == "OBJECT"
        assert np.array_equal(selected_vertices(item), before)
        assert own_names(item) == {"sg_keypoint", "sg_color"}
        bpy.ops.ed.redo()
        item = bpy.data.objects["Creature"]
        assert item.mode == "EDIT"
        item.update_from_editmode()
        assert 0 < len(selected_vertices(item)) < len(before)  # a new mesh has all selected
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_without_keypoints_there_is_nothing_to_select(self, modules: Any) -> None:
        item = add_blob()
        assert not bpy.ops.shape_google.select_keypoints.poll()
        item.data.attributes.new("sg_keypoint", "FLOAT", "POINT")
        assert bpy.ops.shape_google.select_keypoints() == {"CANCELLED"}
        assert item.mode == "OBJECT"

    def test_hidden_ones_stay_unselected(self, modules: Any) -> None:
        item = add_creature()
        paint("KEYPOINTS")
        points = np.flatnonzero(modules.attributes.values_of(item.data, "sg_keypoint"))
        item.data.vertices[points[0]].hide = True
        bpy.ops.shape_google.select_keypoints()
        bpy.ops.object.mode_set(mode="OBJECT")
        assert np.array_equal(selected_vertices(item), points[1:])

    def test_other_detectors_in_edit_mode_and_clearing(self, modules: Any) -> None:
        item = add_creature()
        paint("KEYPOINTS", detector="hks-maxima")
        bpy.ops.object.mode_set(mode="EDIT")
        paint("KEYPOINTS", detector="salient-points")
        bpy.ops.object.mode_set(mode="OBJECT")
        expected = sg.vertex_keypoints(modules.scene.base_mesh(item), "salient-points")
        response = modules.attributes.values_of(item.data, "sg_keypoint")
        assert set(np.flatnonzero(response)) == set(expected.indices)
        assert bpy.ops.shape_google.clear_paint() == {"FINISHED"}
        assert not own_names(item)
