# SPDX-License-Identifier: MIT
"""Transferring vertex groups, colours and UVs from a match to the query."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from tests.addon.shapes import open_source


def lumpy(name: str, subdivisions: int = 4, twist: float = 0.0) -> Any:
    """A lopsided body, twisted more or less; the same surface at every number of subdivisions."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, calc_uvs=False)
    item = bpy.context.object
    item.name = name
    count = len(item.data.vertices)
    points = np.empty((count, 3), np.float32)
    item.data.vertices.foreach_get("co", points.ravel())
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    x, y, z = points.T.astype(np.float64)
    grown = points * [1, 1.2, 2]
    for nose, height in (((0.8, 0.2, 0.6), 1.2), ((-0.3, 0.8, -0.5), 0.8), ((0.3, -0.8, -0.5), 0.4)):
        near = np.exp(-10 * (1 - points @ np.array(nose, np.float32) / np.linalg.norm(nose)))
        grown = grown * (1 + height * near)[:, None]
    angle = twist * grown[:, 2]
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = np.stack(
        [
            cosine * grown[:, 0] - sine * grown[:, 1],
            sine * grown[:, 0] + cosine * grown[:, 1],
            grown[:, 2],
        ],
        axis=1,
    )
    item.data.vertices.foreach_set("co", turned.astype(np.float32).ravel())
    item.data.update()
    return item, np.stack([x, y, z], axis=1)


def dress(item: Any, sphere: np.ndarray) -> None:
    """Give a body weights, colours and UVs that are functions of where on the sphere a vertex was."""
    high = item.vertex_groups.new(name="high")
    low = item.vertex_groups.new(name="low")
    for vertex, z in enumerate(sphere[:, 2]):
        high.add([vertex], float((1 + z) / 2), "REPLACE")
        if z < -0.5:
            low.add([vertex], 1.0, "REPLACE")
    data = item.data
    color = data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    values = np.concatenate([(sphere + 1) / 2, np.ones((len(sphere), 1))], axis=1).astype(np.float32)
    color.data.foreach_set("color", values.ravel())
    corners = data.color_attributes.new("Corners", "BYTE_COLOR", "CORNER")
    vertices = np.empty(len(data.loops), np.int32)
    data.loops.foreach_get("vertex_index", vertices)
    corners.data.foreach_set("color", values[vertices].ravel())
    # Two pieces, apart: upper and lower half, cut along the equator.
    uv = data.uv_layers.new(name="Map")
    coordinates = sphere[vertices, :2] * 0.2 + 0.25
    for polygon in data.polygons:
        if np.mean([sphere[vertex, 2] for vertex in polygon.vertices]) > 0:
            coordinates[list(polygon.loop_indices)] += 0.5
    uv.uv.foreach_set("vector", coordinates.astype(np.float32).ravel())


def choose(name: str, source: Path | str) -> None:
    match = bpy.context.window_manager.shape_google.matches.add()
    match.name = match.object_name = name
    match.source = str(source)
    bpy.context.window_manager.shape_google.active_match = 0


def weights_of(item: Any, name: str) -> np.ndarray:
    index = item.vertex_groups[name].index
    return np.array(
        [
            sum(entry.weight for entry in vertex.groups if entry.group == index)
            for vertex in item.data.vertices
        ]
    )


@pytest.fixture
def pair(blender: Any) -> Any:
    """A dressed body, and a twisted one of another mesh with nothing on it, which is active."""
    source, sphere = lumpy("Source", 4)
    dress(source, sphere)
    target, sphere = lumpy("Target", 5, twist=0.1)
    target.location = (5, 0, 0)
    bpy.context.view_layer.update()
    session = bpy.context.window_manager.shape_google
    for name in ("groups", "colors", "uvs", "replace"):
        session.property_unset(f"transfer_{name}")
    return source, target, sphere


def test_weights_colors_and_uvs_arrive(pair: Any, capfd: pytest.CaptureFixture[str]) -> None:
    _, target, sphere = pair
    choose("Source", open_source())
    assert bpy.ops.shape_google.transfer_match() == {"FINISHED"}
    said = capfd.readouterr().out
    assert "2 vertex groups, 2 color attributes, 1 UV map from 'Source' to 'Target'" in said
    off = np.abs(weights_of(target, "high") - (1 + sphere[:, 2]) / 2)
    assert off.mean() < 0.02
    assert off.max() < 0.1
    low = weights_of(target, "low")
    assert low[sphere[:, 2] < -0.65].min() > 0.9
    assert low[sphere[:, 2] > -0.35].max() == 0
    data = target.data
    color = np.empty((len(data.vertices), 4), np.float32)
    data.color_attributes["Paint"].data.foreach_get("color", color.ravel())
    assert np.abs(color[:, :3] - (sphere + 1) / 2).mean() < 0.03
    corners = data.color_attributes["Corners"]
    assert (corners.domain, corners.data_type) == ("CORNER", "BYTE_COLOR")


def test_a_rig_stands_for_its_mesh(pair: Any, capfd: pytest.CaptureFixture[str]) -> None:
    """Both as what is active, and as what else is deformed by it: a hidden mesh is not meant."""
    _, target, sphere = pair
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.collection.objects.link(rig)
    hidden = bpy.data.objects.new("Proxy", target.data.copy())
    bpy.context.collection.objects.link(hidden)
    for item in (target, hidden):
        item.modifiers.new("Armature", "ARMATURE").object = rig
    hidden.hide_set(True)
    bpy.context.view_layer.objects.active = rig
    session = bpy.context.window_manager.shape_google
    session.transfer_colors = session.transfer_uvs = False
    choose("Source", open_source())
    assert bpy.ops.shape_google.transfer_match() == {"FINISHED"}
    assert "from 'Source' to 'Target'" in capfd.readouterr().out
    assert np.abs(weights_of(target, "high") - (1 + sphere[:, 2]) / 2).mean() < 0.02
    assert not hidden.vertex_groups


def test_no_face_spans_a_seam(pair: Any) -> None:
    _, target, sphere = pair
    choose("Source", open_source())
    bpy.ops.shape_google.transfer_match()
    data = target.data
    uv = np.empty((len(data.loops), 2), np.float32)
    data.uv_layers["Map"].uv.foreach_get("vector", uv.ravel())
    sizes = [np.ptp(uv[list(polygon.loop_indices)], axis=0).max() for polygon in data.polygons]
    assert max(sizes) < 0.2  # the pieces are 0.5 apart
    upper = np.array([np.mean([sphere[v, 2] for v in polygon.vertices]) > 0.1 for polygon in data.polygons])
    first = np.array([uv[polygon.loop_indices[0], 0] > 0.475 for polygon in data.polygons])
    assert first[upper].all()


def test_existing_ones_are_kept_unless_replaced(pair: Any, capfd: pytest.CaptureFixture[str]) -> None:
    _, target, _ = pair
    target.vertex_groups.new(name="high").add([0, 1], 0.25, "REPLACE")
    target.vertex_groups.new(name="low").lock_weight = True
    target.data.uv_layers.new(name="Map")
    choose("Source", open_source())
    assert bpy.ops.shape_google.transfer_match() == {"FINISHED"}
    said = capfd.readouterr().out
    assert "Kept unchanged: 'high', 'low', 'Map'" in said
    assert "Transferred 2 color attributes from" in said
    assert weights_of(target, "high").sum() == pytest.approx(0.5)
    session = bpy.context.window_manager.shape_google
    session.transfer_replace, session.transfer_colors = True, False
    assert bpy.ops.shape_google.transfer_match() == {"FINISHED"}
    assert weights_of(target, "high").mean() > 0.4
    assert weights_of(target, "low").sum() == 0  # locked
    assert len(target.vertex_groups) == 2
    assert len(target.data.uv_layers) == 1


def test_that_all_is_kept_is_said_before_anything_is_matched(
    pair: Any, addon: ModuleType, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    _, target, _ = pair
    for name in ("high", "low"):
        target.vertex_groups.new(name=name)
    session = bpy.context.window_manager.shape_google
    session.transfer_colors = session.transfer_uvs = False
    monkeypatch.setattr(importlib.import_module(f"{addon.__name__}.jobs"), "worker", None)
    choose("Source", open_source())
    assert bpy.ops.shape_google.transfer_match() == {"CANCELLED"}
    assert "Kept unchanged: 'high', 'low'" in capfd.readouterr().out


def test_from_another_file_leaves_nothing_behind(pair: Any, tmp_path: Path) -> None:
    source, target, sphere = pair
    bpy.context.view_layer.objects.active = target
    target.select_set(True)
    path = tmp_path / "source.blend"
    source.data.materials.append(bpy.data.materials.new("Skin"))
    bpy.data.libraries.write(str(path), {source})
    bpy.data.batch_remove([source.data.materials[0], source.data, source])
    before = {block.name_full for block in bpy.data.user_map()}
    choose("Source", path)
    bpy.context.window_manager.shape_google.transfer_uvs = False
    assert bpy.ops.shape_google.transfer_match() == {"FINISHED"}
    assert {block.name_full for block in bpy.data.user_map()} == before
    assert np.abs(weights_of(target, "high") - (1 + sphere[:, 2]) / 2).mean() < 0.02
    assert (bpy.context.active_object, bpy.context.selected_objects) == (target, [target])


def test_what_cannot_be_matched_is_named_and_nothing_is_changed(pair: Any) -> None:
    _, target, _ = pair
    points = bpy.data.meshes.new("Points")
    points.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1)], [])
    cloud = bpy.data.objects.new("Points", points)
    cloud.vertex_groups.new(name="all").add([0, 1, 2], 1.0, "REPLACE")
    bpy.context.collection.objects.link(cloud)
    choose("Points", open_source())
    with pytest.raises(RuntimeError, match="'Points' has no faces"):
        bpy.ops.shape_google.transfer_match()
    assert not target.vertex_groups


def test_nothing_to_transfer_and_itself(pair: Any) -> None:
    _, target, _ = pair
    choose("Target", open_source())
    with pytest.raises(RuntimeError, match="'Target' is the match itself"):
        bpy.ops.shape_google.transfer_match()
    bare, _ = lumpy("Bare")
    bpy.context.view_layer.objects.active = target
    match = bpy.context.window_manager.shape_google.matches[0]
    match.name = match.object_name = bare.name
    with pytest.raises(RuntimeError, match="'Bare' has none of the data to transfer: vertex groups"):
        bpy.ops.shape_google.transfer_match()
    session = bpy.context.window_manager.shape_google
    session.transfer_groups = session.transfer_colors = session.transfer_uvs = False
    assert not bpy.ops.shape_google.transfer_match.poll()


def test_a_match_is_called_what_it_is_called_in_its_file(
    pair: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Where the scene has an object of that name, Blender numbers the one that is brought in."""
    source, target, _ = pair
    bare, _ = lumpy("Bare")
    path = tmp_path / "assets.blend"
    bpy.data.libraries.write(str(path), {source, bare}, fake_user=True)
    bpy.context.view_layer.objects.active = target
    choose("Bare", path)
    with pytest.raises(RuntimeError, match="'Bare' has none of the data to transfer"):
        bpy.ops.shape_google.transfer_match()
    match = bpy.context.window_manager.shape_google.matches[0]
    match.name = match.object_name = source.name
    assert bpy.ops.shape_google.transfer_match() == {"FINISHED"}
    assert "from 'Source' to 'Target'" in capfd.readouterr().out


def test_a_mirrored_object_keeps_its_corners(pair: Any) -> None:
    """Its triangles are turned for matching; what belongs to their corners has to turn along."""
    source, target, sphere = pair
    source.scale = (-1, 1, 1)
    target.scale = (-1, 1, 1)
    bpy.context.view_layer.update()
    choose("Source", open_source())
    bpy.ops.shape_google.transfer_match()
    data = target.data
    vertices = np.empty(len(data.loops), np.int32)
    data.loops.foreach_get("vertex_index", vertices)
    color = np.empty((len(data.loops), 4), np.float32)
    data.color_attributes["Corners"].data.foreach_get("color", color.ravel())
    assert np.abs(color[:, :3] - (sphere[vertices] + 1) / 2).mean() < 0.03


def test_it_is_undone_in_one_step(pair: Any) -> None:
    bpy.context.preferences.edit.use_global_undo = True
    choose("Source", open_source())
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.shape_google.transfer_match() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Transfer")
    bpy.ops.ed.undo()
    target = bpy.data.objects["Target"]
    assert not target.vertex_groups
    assert not target.data.color_attributes
    assert not target.data.uv_layers
