# SPDX-License-Identifier: MIT
"""Rigs, lattices, empties and collection instances stand for the meshes that they move."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from shapegoogle_core import MeshError
from tests.addon.shapes import open_source

CARRIERS = ("rig", "lattice", "empty", "instance")


@pytest.fixture
def meshes(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.scene.query")


def add_ball(name: str, x: float) -> Any:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, location=(x, 0, 0))
    bpy.context.object.name = name
    return bpy.context.object


def carry(kind: str) -> Any:
    """Two balls, the first twice as large, that belong to an object which is the only one selected."""
    balls = [add_ball("Body", 0), add_ball("Hat", 3)]
    balls[0].scale = 2, 2, 2
    if kind == "rig":
        bpy.ops.object.armature_add()
    elif kind == "lattice":
        bpy.ops.object.add(type="LATTICE")
    else:
        bpy.ops.object.empty_add()
    carrier = bpy.context.object
    carrier.name = "Carrier"
    if kind in ("rig", "lattice"):
        balls[0].modifiers.new("Carried", {"rig": "ARMATURE", "lattice": "LATTICE"}[kind]).object = carrier
        balls[1].parent = balls[0]
        balls[1].parent = carrier
    elif kind == "empty":
        between = bpy.data.objects.new("Between", None)
        bpy.context.collection.objects.link(between)
        between.parent = carrier
        for ball in balls:
            ball.parent = between
    else:
        collection = bpy.data.collections.new("Carried")
        bpy.context.scene.collection.children.link(collection)
        for ball in balls:
            bpy.context.collection.objects.unlink(ball)
            collection.objects.link(ball)
        bpy.context.view_layer.layer_collection.children["Carried"].exclude = True
        carrier.instance_type, carrier.instance_collection = "COLLECTION", collection
        carrier.location = 10, 0, 0
    bpy.context.view_layer.update()
    return carrier


@pytest.mark.parametrize("kind", CARRIERS)
def test_all_its_meshes_are_one_query(meshes: Any, kind: str) -> None:
    carry(kind)
    other = add_ball("Another", -9)
    other.select_set(False)
    bpy.context.view_layer.objects.active = bpy.data.objects["Carrier"]
    (mesh,) = meshes.query_meshes(bpy.context)
    assert mesh.name == "Carrier"
    assert len(mesh.vertices) == 2 * len(other.data.vertices)
    low, high = mesh.vertices.min(0), mesh.vertices.max(0)
    shift = 10 if kind == "instance" else 0
    np.testing.assert_allclose((low[0], high[0]), (shift - 2, shift + 4), atol=0.02)


def test_with_one_of_its_meshes_selected_only_that_is_meant(meshes: Any) -> None:
    carrier = carry("rig")
    hat = bpy.data.objects["Hat"]
    for item in (carrier, hat):
        item.select_set(True)
    (mesh,) = meshes.query_meshes(bpy.context)
    assert (mesh.name, len(mesh.vertices)) == ("Hat", len(hat.data.vertices))


def test_a_hidden_mesh_is_no_part_and_none_is_refused(meshes: Any) -> None:
    carry("rig")
    bpy.data.objects["Hat"].hide_set(True)
    (mesh,) = meshes.query_meshes(bpy.context)
    assert len(mesh.vertices) == len(bpy.data.objects["Body"].data.vertices)
    bpy.data.objects["Body"].hide_set(True)
    with pytest.raises(MeshError, match="'Carrier' has no visible mesh"):
        meshes.query_meshes(bpy.context)


def test_its_meshes_are_painted_and_marked() -> None:
    carrier = carry("rig")
    bpy.context.scene.shape_google_painting.kind = "HKS"
    assert bpy.ops.shape_google.paint() == {"FINISHED"}
    assert all("sg_hks" in bpy.data.objects[name].data.attributes for name in ("Body", "Hat"))
    match = bpy.context.window_manager.shape_google.matches.add()
    match.name = match.object_name = "Hat"
    match.source = open_source()
    bpy.context.window_manager.shape_google.active_match = 0
    bpy.context.view_layer.objects.active = carrier
    assert bpy.ops.shape_google.mark_match() == {"FINISHED"}
    assert all("sg_word" in bpy.data.objects[name].data.attributes for name in ("Body", "Hat"))
    assert bpy.context.active_object == carrier


def test_one_that_carries_nothing_is_refused() -> None:
    bpy.ops.object.empty_add()
    assert bpy.ops.shape_google.paint.poll()
    with pytest.raises(RuntimeError, match="'Empty' has no visible mesh"):
        bpy.ops.shape_google.paint()


def test_instances_of_one_mesh_are_where_they_are_seen_and_not_inside_out(meshes: Any) -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    collection = bpy.data.collections.new("Balls")
    ball = add_ball("Ball", 0)
    bpy.context.collection.objects.unlink(ball)
    volumes = []
    for x, scale in ((0, (1, 1, 1)), (5, (-1, 1, 1)), (9, (1, 2, 3))):
        item = ball if not x else bpy.data.objects.new("Copy", ball.data)
        item.location.x, item.scale = x, scale
        collection.objects.link(item)
        volumes.append(abs(float(np.prod(scale))))
    carrier = bpy.data.objects.new("Carrier", None)
    carrier.instance_type, carrier.instance_collection = "COLLECTION", collection
    carrier.location.z = 10
    bpy.context.collection.objects.link(carrier)
    bpy.context.view_layer.update()
    mesh = meshes.object_mesh(carrier, bpy.context)
    faces = len(ball.data.polygons)
    assert len(mesh.faces) == 3 * faces
    corners = mesh.vertices[mesh.faces].reshape(3, faces, 3, 3)
    np.testing.assert_allclose(corners.mean((1, 2)), [(0, 0, 10), (5, 0, 10), (9, 0, 10)], atol=1e-4)
    centered = corners - corners.mean((1, 2), keepdims=True)
    signed = np.einsum("kfi,kfi->k", centered[:, :, 0], np.cross(centered[:, :, 1], centered[:, :, 2])) / 6
    np.testing.assert_allclose(signed / signed[0], volumes, rtol=1e-4)
    assert signed[0] > 0


def scatter(side: int) -> Any:
    """A grid of which each vertex instances a ball, by geometry nodes; the ball is no object of the scene."""
    ball = add_ball("Ball", 0)
    bpy.context.collection.objects.unlink(ball)
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    output, grid, places, info = map(
        tree.nodes.new,
        (
            "NodeGroupOutput",
            "GeometryNodeMeshGrid",
            "GeometryNodeInstanceOnPoints",
            "GeometryNodeObjectInfo",
        ),
    )
    for axis in "XY":
        grid.inputs[f"Vertices {axis}"].default_value = side
        grid.inputs[f"Size {axis}"].default_value = 5 * (side - 1)
    info.inputs["Object"].default_value = ball
    info.inputs["As Instance"].default_value = True
    tree.links.new(grid.outputs["Mesh"], places.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], places.inputs["Instance"])
    tree.links.new(places.outputs["Instances"], output.inputs[0])
    item = bpy.data.objects.new("Scatter", bpy.data.meshes.new("Scatter"))
    bpy.context.collection.objects.link(item)
    item.modifiers.new("Scatter", "NODES").node_group = tree
    item.select_set(True)
    bpy.context.view_layer.objects.active = item
    bpy.context.view_layer.update()
    return item


def test_a_scatter_is_read_in_short_steps_although_the_scene_changes_meanwhile(
    meshes: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    item = scatter(40)
    (whole,) = meshes.query_meshes(bpy.context)
    assert len(whole.faces) == 40 * 40 * len(bpy.data.meshes["Icosphere"].polygons)
    monkeypatch.setattr(meshes, "SECONDS_OF_LISTING", 0.0)
    steps = meshes.query_steps(bpy.context)
    count = 0
    while True:
        try:
            next(steps)
        except StopIteration as end:
            (read,) = end.value
            break
        count += 1
        if count == 2:
            item.data.update_tag()
            add_ball("Another", 9)
    assert count >= 40 * 40 // 500
    np.testing.assert_array_equal(read.faces, whole.faces)
    np.testing.assert_array_equal(read.vertices, whole.vertices)


def test_a_query_says_how_many_of_its_instances_are_left_out(
    addon: ModuleType, meshes: Any, preferences: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    bpy.ops.wm.read_homefile(use_empty=True)
    item = scatter(4)
    preferences.use_scene = True
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    notes: list[str] = []
    meshes.query_meshes(bpy.context, notes=notes)
    assert not notes
    for module in (meshes, importlib.import_module(f"{addon.__name__}.reading.instancers")):
        monkeypatch.setattr(module, "MOST_INSTANCES", 10)
    (mesh,) = meshes.query_meshes(bpy.context, notes=notes)
    assert len(mesh.faces) == 10 * len(bpy.data.meshes["Icosphere"].polygons)
    assert notes == ["only the first 10 of the 16 instances of 'Scatter' are part of the query"]
    # In the window it is said beside the answer, also when this is given again under other filters.
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    session = bpy.context.window_manager.shape_google
    assert session.answer.endswith(f"; {notes[0]}")
    importlib.import_module(f"{addon.__name__}.search.operators").refine_and_wait(bpy.context)
    assert session.answer.endswith(f"; {notes[0]}")
    item.select_set(False)
    add_ball("Other", 99)
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    assert "instances" not in session.answer
