# SPDX-License-Identifier: MIT
"""Objects to paint, and painting them."""

from __future__ import annotations

import importlib
from typing import Any

import bpy
import numpy as np

from benchmarks.creatures import make_creature
from tests.addon.conftest import addon_name


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
