# SPDX-License-Identifier: MIT
"""What is painted equals what the core computes, shows at once, can be undone and cleared."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import bmesh
import bpy
import numpy as np
import pytest

import shapegoogle_core as sg
from benchmarks.creatures import make_creature
from shapegoogle_core.descriptors import time_at, time_range
from shapegoogle_core.keypoints import DETECTORS
from shapegoogle_core.rendering import word_palette
from tests.addon.conftest import addon_name


@pytest.fixture(autouse=True)
def settings(blender: Any) -> Any:
    """Settings of the scene, each at its default."""
    chosen = bpy.context.scene.shape_google_painting
    for name in [entry.identifier for entry in chosen.bl_rna.properties]:
        if name not in ("name", "rna_type"):
            chosen.property_unset(name)
    return chosen


@pytest.fixture
def modules(addon: ModuleType) -> Any:
    """Access to the add-on's modules, whatever its package is called."""

    class Modules:
        def __getattr__(self, name: str) -> Any:
            home = "scene.meshes" if name == "scene" else f"signature.{name}"
            return importlib.import_module(f"{addon.__name__}.{home}")

    return Modules()


def add_blob(subdivisions: int = 4, name: str = "Blob") -> Any:
    """A closed bumpy surface, scaled, turned and moved."""
    bpy.ops.mesh.primitive_ico_sphere_add(
        subdivisions=subdivisions, location=(3, -2, 5), rotation=(0.3, 1, 2)
    )
    item = bpy.context.object
    item.name = name
    item.scale = 1.5, 2, 0.7
    for vertex in item.data.vertices:
        vertex.co *= 1 + 0.2 * np.sin(3 * vertex.co.x) + 0.15 * np.cos(4 * vertex.co.y + vertex.co.z)
    bpy.context.view_layer.update()
    return item


def add_creature(kind: str = "horse", vertex_count: int = 2000) -> Any:
    """A body with limbs, which has keypoints of every detector."""
    mesh = make_creature(kind, 120, vertex_count).pose("rest")
    item = importlib.import_module(f"{addon_name()}.scene.meshes").new_object(bpy.context, mesh, "Creature")
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    bpy.context.view_layer.update()
    return item


def selected_vertices(item: Any) -> np.ndarray:
    selected = np.empty(len(item.data.vertices), bool)
    item.data.vertices.foreach_get("select", selected)
    return np.flatnonzero(selected)


def paint(kind: str, **values: Any) -> set[str]:
    chosen = bpy.context.scene.shape_google_painting
    chosen.kind = kind
    for name, value in values.items():
        setattr(chosen, name, value)
    result: set[str] = bpy.ops.shape_google.paint()
    return result


def own_names(item: Any) -> set[str]:
    return {attribute.name for attribute in item.data.attributes if attribute.name.startswith("sg_")}


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
        assert modules.attributes.picked_vertex(item) == 77
        paint("HEAT", scale=0.2)
        assert np.array_equal(modules.attributes.values_of(item.data, "sg_heat"), heat)

    def test_vertex_selected_by_a_script(self, modules: Any) -> None:
        item = add_blob()
        item.data.vertices.foreach_set("select", np.arange(len(item.data.vertices)) == 33)
        assert modules.attributes.picked_vertex(item) == 33

    def test_heat_without_a_vertex_says_what_to_do(self) -> None:
        item = add_blob()
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.object.mode_set(mode="OBJECT")
        with pytest.raises(RuntimeError, match="'Blob': no vertex of its surface is selected"):
            paint("HEAT")
        assert not own_names(item)


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
            paint(kind)
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
        assert paint("WORDS") == {"FINISHED"}
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


class TestCache:
    def test_moving_and_turning_keeps_the_hash_and_scaling_does_not(self, modules: Any) -> None:
        item = add_blob()
        digest = modules.attributes.geometry_hash(item)
        item.location.x += 100
        item.rotation_euler = (1, 2, 3)
        bpy.context.view_layer.update()
        assert modules.attributes.geometry_hash(item) == digest
        item.scale.y *= -1
        bpy.context.view_layer.update()
        assert modules.attributes.geometry_hash(item) == digest
        for factor in (1.01, 1 + 1e-5):
            item.scale.x *= factor
            bpy.context.view_layer.update()
            assert modules.attributes.geometry_hash(item) != digest
            digest = modules.attributes.geometry_hash(item)

    def test_another_cut_of_the_same_bytes_is_another_hash(self, modules: Any) -> None:
        """The corners of two meshes may be the same numbers in the same order."""
        digests = set()
        for polygons in ([(0, 1, 2, 3), (0, 3, 4, 5)], [(0, 1, 2), (3, 0, 3, 4, 5)]):
            data = bpy.data.meshes.new("Sheet")
            data.from_pydata([(x, y, 0) for x in range(3) for y in range(2)], [], polygons)
            item = bpy.data.objects.new("Sheet", data)
            bpy.context.collection.objects.link(item)
            digests.add(modules.attributes.geometry_hash(item))
        assert len(digests) == 2

    def test_is_bounded(self, modules: Any, monkeypatch: pytest.MonkeyPatch) -> None:
        spectra = modules.results
        importlib.import_module(f"{addon_name()}.state").current().signature.results.clear()
        items = [add_blob(3, f"Blob{number}") for number in range(3)]
        for number, item in enumerate(items):
            item.data.vertices[0].co.x += 0.1 * number
        paint_each = [spectra.key_of(item, modules.choices.Painting(), None) for item in items]
        for index, item in enumerate(items):
            task = spectra.task_of(item, modules.choices.Painting(), None, paint_each[index])
            entry = spectra.remember(task, task.function(*task.arguments))
            monkeypatch.setattr(spectra, "MOST_BYTES", 2 * entry.bytes)
        assert [spectra.known(key) is not None for key in paint_each] == [False, True, True]

    def test_is_dropped_with_the_file(self, modules: Any, tmp_path: Path) -> None:
        item = add_blob()
        paint("HKS")
        key = modules.results.key_of(item, modules.properties.settings_of(bpy.context.scene), None)
        assert modules.results.known(key) is not None
        path = str(tmp_path / "empty.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
        bpy.ops.wm.open_mainfile(filepath=path)
        assert modules.results.known(key) is None


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
