# SPDX-License-Identifier: MIT
"""Colours of objects in pictures."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import bpy
import pytest


@pytest.fixture
def color_of(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.reading.colors").color_of


def material(name: str, color: tuple[float, float, float], *, nodes: bool = True) -> Any:
    made = bpy.data.materials.new(name)
    made.use_nodes = nodes
    made.diffuse_color = (*color, 1)
    if nodes:
        made.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (*color, 1)
    return made


@pytest.mark.parametrize("nodes", [True, False])
def test_an_object_has_the_colour_of_most_of_its_faces(blender: Any, color_of: Any, nodes: bool) -> None:
    if not nodes and bpy.app.version >= (5, 0):
        pytest.skip("all materials of this Blender have nodes")
    bpy.ops.mesh.primitive_cube_add()
    item = bpy.context.object
    assert color_of(item) is None
    item.data.materials.append(material("Blue", (0, 0, 1), nodes=nodes))
    item.data.materials.append(material("Red", (1, 0, 0), nodes=nodes))
    blue = color_of(item)
    assert blue[2] == pytest.approx(1)
    assert blue[2] > blue[0] > 0  # black would not be seen on a dark interface
    for polygon in item.data.polygons[:4]:
        polygon.material_index = 1
    assert color_of(item) == pytest.approx(blue[::-1])


def test_what_a_texture_colours_has_none(blender: Any, color_of: Any) -> None:
    bpy.ops.mesh.primitive_cube_add()
    item = bpy.context.object
    made = material("Wood", (1, 0, 0))
    item.data.materials.append(made)
    tree = made.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    tree.links.new(texture.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    assert color_of(item) is None
    item.data.materials[0] = None
    assert color_of(item) is None
