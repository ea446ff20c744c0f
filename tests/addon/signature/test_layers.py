# SPDX-License-Identifier: MIT
"""Values and colours that are painted equal those of the core."""

from __future__ import annotations

from typing import Any

import bmesh
import bpy
import numpy as np
import pytest

import shapegoogle_core as sg
from shapegoogle_core.descriptors import time_at, time_range
from shapegoogle_core.rendering import word_palette
from tests.addon.signature.objects import add_blob, own_names, paint


class TestValues:
    @pytest.mark.parametrize(
        "laplacian", ["robust", "cotangent", "cotangent-voronoi", "fem1", "fem2", "fem3"]
    )
    def test_hks_is_that_of_the_core(self, modules: Any, laplacian: str) -> None:
        item = add_blob()
        assert paint("HKS", scale=0.3, laplacian=laplacian, eigenpairs=60) == {"FINISHED"}
        spectrum = sg.compute_spectrum(modules.scene.base_mesh(item), 60, laplacian)
        decay = 4 * np.log(10)
        low, high = decay / spectrum.eigenvalues[-1], decay / spectrum.eigenvalues[1]
        time = low * (high / low) ** 0.3
        expected = sg.heat_kernel_signature(spectrum, [time])[:, 0]
        attribute = item.data.attributes["sg_hks"]
        assert (attribute.domain, attribute.data_type) == ("POINT", "FLOAT")
        assert np.allclose(modules.attributes.values_of(item.data, "sg_hks"), expected, rtol=1e-5, atol=0)

    def test_several_times(self, modules: Any) -> None:
        item = add_blob()
        paint("HKS_TIMES", count=4, eigenpairs=50)
        spectrum = sg.compute_spectrum(modules.scene.base_mesh(item), 50)
        times = np.geomspace(*time_range(spectrum), 4)
        written = [modules.attributes.values_of(item.data, f"sg_hks_{number}") for number in range(1, 5)]
        expected = sg.heat_kernel_signature(spectrum, times)
        assert np.allclose(np.stack(written, axis=1), expected, rtol=1e-5, atol=0)
        paint("HKS_TIMES", count=2)
        assert own_names(item) == {"sg_hks_1", "sg_hks_2", "sg_color"}

    def test_scale_invariant_signature_does_not_know_the_size(self, modules: Any) -> None:
        item = add_blob()
        paint("SI_HKS", frequencies=3)
        names = ["sg_sihks_0", "sg_sihks_1", "sg_sihks_2"]
        small = [modules.attributes.values_of(item.data, name) for name in names]
        item.scale = 7 * item.scale
        bpy.context.view_layer.update()
        paint("SI_HKS", frequencies=3)
        large = [modules.attributes.values_of(item.data, name) for name in names]
        assert np.allclose(small, large, rtol=1e-3, atol=1e-4)
        assert np.ptp(small[1]) > 0.01

    def test_words_and_weights_are_those_of_the_model(self, modules: Any) -> None:
        item = add_blob()
        paint("WORDS", weights=3)
        expected = sg.vertex_words(sg.load_model(), modules.scene.base_mesh(item))
        word = modules.attributes.values_of(item.data, "sg_word")
        assert np.array_equal(word, expected.heaviest)
        weights = {name for name in own_names(item) if name.startswith("sg_weight_")}
        assert weights == {f"sg_weight_{index}" for index in np.argsort(-expected.bag)[:3]}
        for name in weights:
            theta = expected.weights()[:, int(name.rpartition("_")[2])]
            assert np.allclose(modules.attributes.values_of(item.data, name), theta, atol=1e-6)

    def test_word_colours_are_linear_and_the_same_on_every_shape(self, modules: Any) -> None:
        palette = modules.layers.linear_rgb(word_palette(40))
        for subdivisions in (4, 3):
            item = add_blob(subdivisions)
            paint("WORDS")
            colors = modules.attributes.values_of(item.data, "sg_color")
            word = modules.attributes.values_of(item.data, "sg_word")
            assert np.allclose(colors[:, :3], palette[word], atol=1e-6)
            assert (colors[:, 3] == 1).all()
        # Blender's own conversion agrees.
        byte = item.data.color_attributes.new("byte", "BYTE_COLOR", "POINT")
        byte.data.foreach_set("color", colors.ravel())
        shown = np.empty(colors.size, np.float32)
        byte.data.foreach_get("color_srgb", shown)
        assert np.allclose(shown.reshape(-1, 4)[:, :3], word_palette(40)[word], atol=0.005)

    def test_rgb_is_three_components(self, modules: Any) -> None:
        item = add_blob()
        paint("RGB")
        assert own_names(item) == {"sg_hks_1", "sg_hks_2", "sg_hks_3", "sg_color"}
        colors = modules.attributes.values_of(item.data, "sg_color")[:, :3]
        values = [modules.attributes.values_of(item.data, f"sg_hks_{channel}") for channel in (1, 2, 3)]
        descriptor = np.stack(values, axis=1)
        descriptor /= np.linalg.norm(descriptor, axis=1, keepdims=True)  # the paper's equation 2
        for channel in range(3):
            order = np.argsort(descriptor[:, channel])
            assert (np.diff(colors[order, channel]) >= -1e-4).all()
            assert colors[:, channel].min() == 0
            assert colors[:, channel].max() == 1

    def test_heat_spreads_from_the_active_vertex(self, modules: Any) -> None:
        item = add_blob()
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        edited = bmesh.from_edit_mesh(item.data)
        edited.verts.ensure_lookup_table()
        for index in (5, 77):
            edited.verts[index].select_set(True)
        edited.select_history.add(edited.verts[77])
        bmesh.update_edit_mesh(item.data)
        paint("HEAT", scale=0.2)
        bpy.ops.object.mode_set(mode="OBJECT")
        heat = modules.attributes.values_of(item.data, "sg_heat")
        spectrum = sg.compute_spectrum(modules.scene.base_mesh(item), 100)
        expected = sg.heat_kernel(spectrum, 77, time_at(spectrum, 0.2))
        assert np.allclose(heat, expected, rtol=1e-5, atol=1e-5 * expected.max())
        assert heat @ spectrum.mass == pytest.approx(1, rel=1e-4)
        # The selection is kept in object mode, and so is the active vertex.
        assert modules.picked.picked(item).index == 77
        paint("HEAT", scale=0.2)
        assert np.array_equal(modules.attributes.values_of(item.data, "sg_heat"), heat)

    def test_vertex_selected_by_a_script(self, modules: Any) -> None:
        item = add_blob()
        item.data.vertices.foreach_set("select", np.arange(len(item.data.vertices)) == 33)
        assert modules.picked.picked(item).index == 33

    def test_heat_without_a_vertex_says_what_to_do(self) -> None:
        item = add_blob()
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.object.mode_set(mode="OBJECT")
        with pytest.raises(RuntimeError, match="'Blob': no vertex of its surface is selected"):
            paint("HEAT")
        assert not own_names(item)


class TestUncleanMeshes:
    def test_heat_crosses_split_edges_and_loose_vertices_are_0(self, modules: Any) -> None:
        item = add_blob()
        paint("HKS", eigenpairs=40)
        whole = modules.attributes.values_of(item.data, "sg_hks")
        count = len(whole)
        bpy.ops.object.mode_set(mode="EDIT")
        edited = bmesh.from_edit_mesh(item.data)
        bmesh.ops.split_edges(edited, edges=list(edited.edges)[::2])
        edited.verts.new((9, 9, 9))
        bmesh.update_edit_mesh(item.data)
        bpy.ops.object.mode_set(mode="OBJECT")
        assert len(item.data.vertices) > count
        paint("HKS", eigenpairs=40)
        split = modules.attributes.values_of(item.data, "sg_hks")
        assert np.allclose(split[:count], whole, rtol=1e-4)
        assert split[-1] == 0
        paint("WORDS")
        assert modules.attributes.values_of(item.data, "sg_word")[-1] == -1

    def test_suzanne_has_loose_eyes(self, modules: Any) -> None:
        bpy.ops.mesh.primitive_monkey_add()
        for kind in ("HKS", "HKS_TIMES", "SI_HKS", "WORDS", "RGB", "HEAT", "KEYPOINTS"):
            assert paint(kind) == {"FINISHED"}
        for name in own_names(bpy.context.object):
            assert np.isfinite(modules.attributes.values_of(bpy.context.object.data, name)).all()

    def test_large_objects_are_computed_on_a_copy(self, modules: Any) -> None:
        item = add_blob(5)
        paint("HKS", budget=1_000_000, scale=0.4, eigenpairs=40)
        exact = modules.attributes.values_of(item.data, "sg_hks")
        paint("HKS", budget=1_500, eigenpairs=40)
        near = modules.attributes.values_of(item.data, "sg_hks")
        assert not np.array_equal(near, exact)
        assert np.abs(near / exact - 1).max() < 0.05

    def test_object_without_faces_is_refused_and_others_go_on(self, modules: Any) -> None:
        blob = add_blob()
        bpy.ops.mesh.primitive_circle_add()
        ring = bpy.context.object
        blob.select_set(True)
        assert paint("HKS") == {"FINISHED"}
        assert own_names(blob) == {"sg_hks", "sg_color"}
        assert not own_names(ring)
        blob.select_set(False)
        with pytest.raises(RuntimeError, match="'Circle' has no faces"):
            paint("HKS")
