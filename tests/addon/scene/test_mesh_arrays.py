# SPDX-License-Identifier: MIT
"""Reading meshes as blocks gives what Blender says of each vertex, corner and triangle."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest


def same_as_blender_says(addon: ModuleType, data: Any) -> bool:
    arrays = import_module(f"{addon.__name__}.scene.mesh_arrays")
    faces = arrays.triangles(data)
    return bool(
        arrays.vertex_positions(data).tolist() == [list(vertex.co) for vertex in data.vertices]
        and arrays.corner_vertices(data).tolist() == [loop.vertex_index for loop in data.loops]
        and arrays.edge_vertices(data).tolist() == [list(edge.vertices) for edge in data.edges]
        and arrays.polygon_sizes(data).tolist() == [polygon.loop_total for polygon in data.polygons]
        and faces.tolist() == [list(triangle.vertices) for triangle in data.loop_triangles]
    )


@pytest.mark.parametrize(
    "add",
    [
        lambda: bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2),  # triangles
        lambda: bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6),  # and quads
        lambda: bpy.ops.mesh.primitive_cylinder_add(vertices=7),  # and polygons
        lambda: bpy.ops.mesh.primitive_circle_add(),  # edges alone
    ],
)
def test_blocks_and_single_values_agree(blender: Any, addon: ModuleType, add: Any) -> None:
    add()
    item = bpy.context.object
    assert same_as_blender_says(addon, item.data)
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    assert same_as_blender_says(addon, evaluated.to_mesh())
    evaluated.to_mesh_clear()


def test_a_mesh_that_is_edited_is_read_too(blender: Any, addon: ModuleType) -> None:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    data = bpy.context.object.data
    before = len(data.vertices)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.context.object.update_from_editmode()
    assert len(data.vertices) > before
    assert same_as_blender_says(addon, data)


def test_nothing_to_read(blender: Any, addon: ModuleType) -> None:
    data = bpy.data.meshes.new("empty")
    arrays = import_module(f"{addon.__name__}.scene.mesh_arrays")
    assert arrays.vertex_positions(data).shape == (0, 3)
    assert arrays.corner_vertices(data).shape == (0,)
    assert arrays.edge_vertices(data).shape == (0, 2)
    assert arrays.polygon_sizes(data).shape == (0,)
    assert arrays.triangles(data).shape == (0, 3)
    assert arrays.triangles(data).dtype == np.int32
