# SPDX-License-Identifier: MIT
"""Objects of the open scene as meshes: which ones can be read at all, and which shape the user means."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import bmesh
import bpy
import numpy as np
import pytest

from shapegoogle_core import MeshError
from tests.addon.conftest import to_point_cloud


@pytest.fixture
def scene(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.scene.query")


@pytest.fixture
def split_evaluated(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.scene.selection").split_evaluated


def add(name: str, collection: Any = None, scale: float = 1) -> Any:
    bpy.ops.mesh.primitive_cube_add()
    item = bpy.context.object
    item.name = name
    item.scale = scale, scale, scale
    if collection is not None:
        for other in item.users_collection:
            other.objects.unlink(item)
        collection.objects.link(item)
    return item


def add_collection(name: str, parent: Any = None) -> Any:
    collection = bpy.data.collections.new(name)
    (parent or bpy.context.scene.collection).children.link(collection)
    return collection


def test_what_the_view_layer_does_not_evaluate(split_evaluated: Any, tmp_path: Path) -> None:
    """The world matrix of such an object is wrong once the file was opened again."""
    layers = bpy.context.view_layer.layer_collection.children
    shown = [add("shown", scale=2)]
    hidden = [add("disabled", scale=2)]
    hidden[0].hide_viewport = True
    hidden.append(add("excluded", add_collection("Excluded")))
    layers["Excluded"].exclude = True
    disabled = add_collection("Disabled")
    disabled.hide_viewport = True
    hidden.append(add("inside", add_collection("Inside", disabled)))
    shown.append(add("in two collections", disabled))
    bpy.context.scene.collection.objects.link(shown[-1])
    shown.append(add("eye closed"))
    shown[-1].hide_set(True)
    shown.append(add("eye of its collection closed", add_collection("Closed")))
    layers["Closed"].hide_viewport = True
    # In the dependency graph for the sake of others, but not as it would be seen.
    hidden.append(add("disabled parent", scale=2))
    hidden[-1].modifiers.new("Subdivision", "SUBSURF")
    shown.append(add("child"))
    shown[-1].parent = hidden[-1]
    hidden[-1].hide_viewport = True
    hidden.append(add("disabled by an animation", scale=2))
    hidden[-1].hide_viewport = True
    hidden[-1].keyframe_insert("hide_viewport", frame=1)
    names = [item.name for item in shown], [item.name for item in hidden]
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    found = split_evaluated(bpy.context.scene.objects, bpy.context)
    assert [{item.name for item in part} for part in found] == [set(part) for part in names]
    assert np.allclose(bpy.data.objects["shown"].matrix_world.to_scale(), 2)
    assert split_evaluated([bpy.data.objects["shown"]], bpy.context)[0]
    assert not split_evaluated([bpy.data.objects["disabled"]], bpy.context)[0]
    # Nothing of the user's was changed to find out.
    assert bpy.data.objects["disabled"].hide_viewport
    assert bpy.context.view_layer.layer_collection.children["Excluded"].exclude


def test_the_selected_faces_of_all_objects_in_edit_mode(scene: Any) -> None:
    items = [add("First"), add("Second", scale=2), add("Third")]
    twin = bpy.data.objects.new("Twin", items[0].data)
    bpy.context.collection.objects.link(twin)
    for item in (*items, twin):
        item.select_set(True)
    items[1].location.x = 10
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = items[0]
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="DESELECT")
    with pytest.raises(MeshError, match=r"'First'.*: no faces are selected"):
        scene.query_meshes(bpy.context)
    select_faces(items[1], 2)
    (part,) = scene.query_meshes(bpy.context)
    assert (part.name, len(part.faces)) == ("Second, selected part", 4)
    assert part.vertices[:, 0].min() >= 8
    select_faces(items[0], 1)
    (part,) = scene.query_meshes(bpy.context)
    # The twin is not counted once more: it is the same mesh, edited once.
    assert (part.name, len(part.faces)) == ("First and 1 more, selected part", 6)
    bpy.ops.object.mode_set(mode="OBJECT")


def add_points(name: str, points: np.ndarray, edges: Any = ()) -> Any:
    """A mesh of vertices without faces, as an imported scan is."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(points.tolist(), edges, [])
    item = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(item)
    bpy.ops.object.select_all(action="DESELECT")
    item.select_set(True)
    bpy.context.view_layer.objects.active = item
    return item


def some_points(count: int = 30) -> np.ndarray:
    return np.random.default_rng(5).random((count, 3))


def test_points_without_faces_are_a_shape(scene: Any) -> None:
    item = add_points("Scan", some_points())
    item.scale = 2, 2, 2
    (cloud,) = scene.query_meshes(bpy.context)
    assert cloud.is_point_cloud
    assert np.allclose(cloud.vertices, 2 * some_points(), atol=1e-6)
    other = add_points("Rest", some_points() + 3)
    item.select_set(True)
    (both,) = scene.query_meshes(bpy.context)
    assert (len(both.vertices), both.is_point_cloud) == (60, True)
    assert len(scene.query_meshes(bpy.context, separate=True)) == 2
    bpy.context.view_layer.objects.active = other
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(MeshError, match=r"'Rest'.*leave edit mode to search with all points"):
        scene.query_meshes(bpy.context)


def test_points_and_surfaces_are_not_joined_but_helpers_are_passed_over(scene: Any) -> None:
    cube = add("Cube")
    add_points("Helper", some_points(2))
    add_points("Wire", some_points(20), [(index, index + 1) for index in range(19)])
    for item in bpy.context.scene.objects:
        item.select_set(True)
    (shape,) = scene.query_meshes(bpy.context)
    assert len(shape.faces) == 12
    add_points("Scan", some_points())
    cube.select_set(True)
    with pytest.raises(MeshError, match="'Scan' is a point cloud and 'Cube' a mesh"):
        scene.query_meshes(bpy.context)
    assert len(scene.query_meshes(bpy.context, separate=True)) == 2


def test_a_wire_is_no_point_cloud(scene: Any) -> None:
    bpy.ops.mesh.primitive_circle_add()
    for separate in (False, True):
        with pytest.raises(MeshError, match="'Circle' has neither faces nor single points"):
            scene.query_meshes(bpy.context, separate=separate)


def test_a_point_cloud_object_is_a_shape(scene: Any, addon: ModuleType) -> None:
    item = add_points("Scan", some_points())
    item.scale = 2, 2, 2
    if not to_point_cloud():
        pytest.skip("this Blender makes no point clouds of meshes")
    assert bpy.context.object.type == "POINTCLOUD"
    (cloud,) = scene.query_meshes(bpy.context)
    assert (cloud.name, cloud.is_point_cloud) == ("Scan", True)
    assert np.allclose(cloud.vertices, 2 * some_points(), atol=1e-6)
    bpy.data.pointclouds.new("Nothing")
    empty = bpy.data.objects.new("Nothing", bpy.data.pointclouds["Nothing"])
    bpy.context.collection.objects.link(empty)
    meshes = importlib.import_module(f"{addon.__name__}.scene.meshes")
    assert meshes.evaluated_mesh(empty).vertices.shape == (0, 3)


def select_faces(item: Any, count: int) -> None:
    edited = bmesh.from_edit_mesh(item.data)
    edited.faces.ensure_lookup_table()
    for face in edited.faces[:count]:
        face.select_set(True)
    bmesh.update_edit_mesh(item.data)
