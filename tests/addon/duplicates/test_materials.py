# SPDX-License-Identifier: MIT
"""Copies of a material, as appending an asset twice makes them, are the same; others are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest

from tests.addon.duplicates.objects import add, find, link, lump, module


@pytest.fixture
def materials(addon: ModuleType) -> Any:
    return module(addon, "duplicates.materials")


def new_material(name: str = "Wood") -> Any:
    """A material with a ramp of colours and a picture from a file."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    ramp, picture = tree.nodes.new("ShaderNodeValToRGB"), tree.nodes.new("ShaderNodeTexImage")
    picture.image = bpy.data.images.new(f"{name} grain", 2, 2)
    picture.image.source, picture.image.filepath = "FILE", "//grain.png"
    tree.links.new(picture.outputs["Color"], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return made


def principled(material: Any) -> Any:
    return material.node_tree.nodes["Principled BSDF"]


def ramp(material: Any) -> Any:
    return next(node for node in material.node_tree.nodes if node.type == "VALTORGB").color_ramp


def picture(material: Any) -> Any:
    return next(node for node in material.node_tree.nodes if node.type == "TEX_IMAGE")


def give_another_picture(material: Any) -> None:
    picture(material).image = picture(material).image.copy()
    picture(material).image.filepath = "//bark.png"


CHANGES: dict[str, Callable[[Any], Any]] = {
    "a value": lambda material: setattr(principled(material).inputs["Roughness"], "default_value", 0.9),
    "a colour": lambda material: setattr(ramp(material).elements[1], "color", (1, 0, 0, 1)),
    "a link": lambda material: material.node_tree.links.remove(material.node_tree.links[0]),
    "a node": lambda material: material.node_tree.nodes.new("ShaderNodeFresnel"),
    "a picture": give_another_picture,
    "a setting": lambda material: setattr(material, "use_backface_culling", True),
    "the name": lambda material: setattr(material, "name", "Stone"),
    "animation": lambda material: material.keyframe_insert("roughness"),
}


def test_copies_are_the_same(materials: Any) -> None:
    first = new_material()
    second = first.copy()
    picture(second).image = picture(first).image.copy()
    second.node_tree.nodes["Principled BSDF"].location.x += 100
    assert second.name != first.name
    assert materials.Materials().are_same([first, None], [second, None])
    assert not materials.Materials().are_same([first], [second, None])
    assert not materials.Materials().are_same([first], [None])


@pytest.mark.parametrize("change", CHANGES)
def test_changed_copies_are_not(materials: Any, change: str) -> None:
    first = new_material()
    second = first.copy()
    CHANGES[change](second)
    assert not materials.Materials().are_same([first], [second])


def test_an_asset_that_was_appended_twice_is_linked(shown: Any, tmp_path: Path) -> None:
    asset = add("Chair", lump())
    asset.data.materials.append(new_material())
    path = tmp_path / "chair.blend"
    bpy.data.libraries.write(str(path), {asset})
    for block in (*bpy.data.objects, *bpy.data.meshes, *bpy.data.materials):
        bpy.data.batch_remove([block])
    for place in range(2):
        with bpy.data.libraries.load(str(path)) as (_, appended):
            appended.objects = ["Chair"]
        (item,) = appended.objects
        bpy.context.scene.collection.objects.link(item)
        item.location.x = 5 * place
    bpy.context.view_layer.update()
    assert len({item.data.materials[0] for item in bpy.context.scene.objects}) == 2
    find(shown)
    (group,) = shown.groups
    assert group.kind == "IDENTICAL"
    assert link(shown) == {"FINISHED"}
    assert len({item.data for item in bpy.context.scene.objects}) == 1
