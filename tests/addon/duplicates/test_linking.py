# SPDX-License-Identifier: MIT
"""Link Data moves nothing, and leaves objects as they are where it could."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from tests.addon.duplicates.objects import add, changed, farthest, find, in_world, link, lump, module, motion


@pytest.mark.parametrize("scale", [1.0, 2.54])
def test_linking_moves_nothing(shown: Any, scale: Any) -> None:
    data = lump()
    order = np.random.default_rng(1).permutation(len(data.vertices))
    items = [
        add("a", data, motion(1)),
        add("copied", data.copy(), motion(2, scale)),
        add("applied", changed(data, motion(3, scale))),
        add("reordered", changed(data, motion(4), order), motion(5, scale)),
    ]
    sibling = add("sibling", items[3].data, motion(6, scale))
    empty = bpy.data.objects.new("parent", None)
    bpy.context.scene.collection.objects.link(empty)
    empty.matrix_world = motion(7)
    items[2].parent = empty
    child = add("child", lump("other", seed=5), motion(8))
    child.parent = items[3]
    bpy.context.view_layer.update()
    before = {item.name: in_world(item) for item in (*items, sibling, child)}
    find(shown)
    assert link(shown) == {"FINISHED"}
    bpy.context.view_layer.update()
    assert len({item.data for item in (*items, sibling)}) == 1
    for item in (*items, sibling, child):
        size = np.linalg.norm(np.ptp(before[item.name], axis=0))
        assert farthest(before[item.name], in_world(item)) <= 1e-4 * size, item.name
    assert find(shown) == {}


def test_modifiers_stay_on_their_objects(shown: Any) -> None:
    data = lump()
    first, second = add("a", data), add("b", data.copy(), motion(2))
    second.modifiers.new("array", "ARRAY").count = 3
    before = in_world(second)
    find(shown)
    assert link(shown) == {"FINISHED"}
    assert first.data == second.data
    assert [modifier.type for modifier in second.modifiers] == ["ARRAY"]
    np.testing.assert_allclose(in_world(second), before, atol=1e-5)


def _shape_keys(item: Any) -> None:
    item.shape_key_add(name="Basis")


def _armature(item: Any) -> None:
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    bpy.context.scene.collection.objects.link(rig)
    for other in (bpy.data.objects["a"], item):
        other.vertex_groups.new(name="bone").add([0, 1], 1.0, "ADD")
    item.modifiers.new("rig", "ARMATURE").object = rig


def _lattice_parent(item: Any) -> None:
    """A parent of this kind deforms it without any modifier."""
    lattice = bpy.data.objects.new("lattice", bpy.data.lattices.new("lattice"))
    bpy.context.scene.collection.objects.link(lattice)
    lattice.data.points[0].co_deform.x -= 1
    item.parent, item.parent_type = lattice, "LATTICE"


def _turned_with_lattice_parent(item: Any) -> None:
    item.data.transform(motion(5))
    _lattice_parent(item)


def _turned_with_modifier(item: Any) -> None:
    item.data.transform(motion(5))
    item.modifiers.new("array", "ARRAY")


def _turned_and_animated(item: Any) -> None:
    item.data.transform(motion(5))
    item.keyframe_insert("location", frame=1)


def _turned_target(item: Any) -> None:
    item.data.transform(motion(5))
    bpy.data.objects["a"].constraints.new("COPY_LOCATION").target = item


def _animated_mesh(item: Any) -> None:
    item.data.driver_add("texspace_location", 0)


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (_shape_keys, "shape keys"),
        (_armature, "armature"),
        (_turned_with_modifier, "modifiers"),
        (_turned_with_lattice_parent, "its parent deforms it"),
        (_turned_and_animated, "animated"),
        (_turned_target, "refers to it"),
        (_animated_mesh, "mesh is animated"),
    ],
)
def test_what_could_be_lost_is_refused(addon: ModuleType, shown: Any, spoil: Any, reason: Any) -> None:
    data = lump()
    add("a", data)
    item = add("b", data.copy(), motion(2))
    spoil(item)
    bpy.context.view_layer.update()
    before, own, matrix = in_world(item), item.data, item.matrix_world.copy()
    result = module(addon, "duplicates.linking").link_data(bpy.context, [bpy.data.objects["a"], item])
    assert result.linked == []
    assert reason in result.refused[0][1]
    assert item.data == own
    assert item.matrix_world == matrix
    np.testing.assert_array_equal(in_world(item), before)


def test_a_skewed_object_is_put_back(addon: ModuleType, shown: Any) -> None:
    """A stretched parent skews what is turned below it: no rotation and scale can hold that."""
    data = lump()
    add("a", data)
    parent = bpy.data.objects.new("stretched", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.matrix_world = Matrix.Diagonal((1, 1, 4, 1))
    item = add("b", data.copy())
    item.parent = parent
    bpy.context.view_layer.update()
    item.data.transform(item.matrix_world.inverted() @ motion(3))
    bpy.context.view_layer.update()
    before, own = in_world(item), item.data
    result = module(addon, "duplicates.linking").link_data(bpy.context, [bpy.data.objects["a"], item])
    assert "cannot hold" in result.refused[0][1]
    assert item.data == own
    np.testing.assert_allclose(in_world(item), before, atol=1e-5)


@pytest.mark.parametrize("how", ["disabled", "excluded"])
def test_what_blender_does_not_evaluate_is_left_out(
    addon: ModuleType, shown: Any, tmp_path: Path, how: Any
) -> None:
    """After opening the file again its world matrix is the identity: linking moved and scaled it."""
    data = lump()
    add("a", data)
    hidden = add("hidden", changed(data, motion(3)))
    hidden.location, hidden.scale = (10, 20, 30), (2, 2, 2)
    if how == "disabled":
        hidden.hide_viewport = True
    else:
        collection = bpy.data.collections.new("Excluded")
        bpy.context.scene.collection.children.link(collection)
        bpy.context.scene.collection.objects.unlink(hidden)
        collection.objects.link(hidden)
        bpy.context.view_layer.layer_collection.children[collection.name].exclude = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    shown = bpy.context.window_manager.shape_google_duplicates
    assert find(shown) == {}
    assert shown.status == "No duplicates in this scene; 1 hidden object was left out"
    # A group may have been found before one of its members was hidden.
    seen, hidden = bpy.data.objects["a"], bpy.data.objects["hidden"]
    for objects in ([seen, hidden], [hidden, seen]):
        result = module(addon, "duplicates.linking").link_data(bpy.context, objects)
        assert result.linked == []
        assert "show it first" in result.refused[0][1]
    assert seen.data != hidden.data
    assert (hidden.location[:], hidden.scale[:]) == ((10, 20, 30), (2, 2, 2))


def test_a_child_that_is_not_evaluated_keeps_its_parent(addon: ModuleType, shown: Any) -> None:
    data = lump()
    add("a", data)
    item = add("b", changed(data, motion(3)))
    child = add("child", lump("other", seed=5))
    child.parent = item
    child.hide_viewport = True
    before = item.matrix_world.copy()
    result = module(addon, "duplicates.linking").link_data(bpy.context, [bpy.data.objects["a"], item])
    assert "children that are disabled" in result.refused[0][1]
    assert item.matrix_world == before


def test_only_chosen_groups_are_linked_and_a_changed_mesh_is_not(shown: Any) -> None:
    first, second = lump(seed=1), lump(seed=2, subdivisions=3)
    for name, data in (("a", first), ("b", second)):
        add(name, data)
        add(f"{name} copy", data.copy(), motion(1))
    find(shown)
    with pytest.raises(RuntimeError, match="Choose at least one group"):
        link(shown, all_groups=False)
    assert bpy.ops.shape_google.choose_duplicates() == {"FINISHED"}
    assert [group.chosen for group in shown.groups] == [True, True]
    bpy.ops.shape_google.choose_duplicates()
    assert [group.chosen for group in shown.groups] == [False, False]
    shown.groups[0].chosen = True
    assert bpy.ops.shape_google.link_duplicates() == {"FINISHED"}
    assert bpy.data.objects["b"].data == bpy.data.objects["b copy"].data  # the larger saving came first
    assert bpy.data.objects["a"].data != bpy.data.objects["a copy"].data
    bpy.data.objects["a copy"].data.vertices[0].co.x += 1
    (left,) = shown.groups  # the linked one is gone from the list
    left.chosen = True
    assert bpy.ops.shape_google.link_duplicates() == {"CANCELLED"}
    assert bpy.data.objects["a"].data != bpy.data.objects["a copy"].data


def test_linking_is_undone_in_one_step(shown: Any) -> None:
    data = lump()
    add("a", data)
    add("b", changed(data, motion(1)))
    bpy.context.preferences.edit.use_global_undo = True
    find(shown)
    bpy.ops.ed.undo_push(message="before")
    matrix = bpy.data.objects["b"].matrix_world.copy()
    assert link(shown) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Link Data")
    bpy.ops.ed.undo()
    assert bpy.data.objects["a"].data != bpy.data.objects["b"].data
    assert bpy.data.objects["b"].matrix_world == matrix
