# SPDX-License-Identifier: MIT
"""Objects that are duplicates of each other, and finding and linking them."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import bpy
import numpy as np
from mathutils import Euler, Matrix


def add(name: str, data: Any, matrix: Any = None) -> Any:
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    if matrix is not None:
        item.matrix_world = matrix
    bpy.context.view_layer.update()
    return item


def lump(name: str = "lump", seed: Any = 0, subdivisions: Any = 2, uv: Any = True) -> Any:
    """A mesh without any symmetry, with a UV map."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions)
    item = bpy.context.object
    data = item.data
    bpy.data.objects.remove(item)
    flat = np.empty(3 * len(data.vertices), np.float32)
    data.vertices.foreach_get("co", flat)
    points = flat.reshape(-1, 3) * (1 + 0.3 * np.random.default_rng(seed).random((len(data.vertices), 1)))
    data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    if not uv:
        data.uv_layers.remove(data.uv_layers[0])
    data.name = name
    data.update()
    return data


def changed(data: Any, transform: Any = None, order: Any = None, name: str = "copy") -> Any:
    """A copy of a mesh with its vertices moved, and counted in another order; UVs stay on their corners."""
    count = len(data.vertices)
    order = np.arange(count) if order is None else order
    new_index = np.argsort(order)
    transform = Matrix() if transform is None else transform
    copy = bpy.data.meshes.new(name)
    points = [transform @ data.vertices[int(index)].co for index in order]
    polygons = list(data.polygons)
    if (order != np.arange(count)).any():
        polygons = polygons[::-1]
    copy.from_pydata(points, [], [[int(new_index[v]) for v in polygon.vertices] for polygon in polygons])
    if data.uv_layers:
        uv = copy.uv_layers.new(name=data.uv_layers[0].name)
        loops = [loop for polygon in polygons for loop in polygon.loop_indices]
        for target, source in enumerate(loops):
            uv.data[target].uv = data.uv_layers[0].data[source].uv
    for polygon, other in zip(copy.polygons, polygons, strict=True):
        polygon.use_smooth = other.use_smooth
    return copy


def motion(seed: Any = 0, scale: Any = 1.0) -> Any:
    random = np.random.default_rng(seed)
    turned = Euler(random.uniform(-3, 3, 3).tolist()).to_matrix().to_4x4()
    return Matrix.Translation(random.uniform(-5, 5, 3).tolist()) @ turned @ Matrix.Scale(scale, 4)


def in_world(item: Any) -> Any:
    """(n, 3) evaluated vertices in the world, in an order of their own."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    data = evaluated.to_mesh()
    points = np.array([evaluated.matrix_world @ vertex.co for vertex in data.vertices])
    evaluated.to_mesh_clear()
    return points


def farthest(one: Any, two: Any) -> Any:
    """Largest distance from a point of one set to the nearest of the other, both ways."""
    distances = np.linalg.norm(one[:, None] - two[None], axis=2)
    return max(distances.min(axis=0).max(), distances.min(axis=1).max())


def kinds(shown: Any) -> Any:
    return {group.kind: [member.name for member in group.members] for group in shown.groups}


def find(shown: Any) -> Any:
    assert bpy.ops.shape_google.find_duplicates() == {"FINISHED"}
    return kinds(shown)


def link(shown: Any, *, all_groups: Any = True) -> Any:
    for group in shown.groups:
        group.chosen = all_groups
    return bpy.ops.shape_google.link_duplicates()


def module(addon: ModuleType, name: str) -> Any:
    return importlib.import_module(f"{addon.__name__}.{name}")
