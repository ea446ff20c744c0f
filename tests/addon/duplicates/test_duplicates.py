# SPDX-License-Identifier: MIT
"""Groups of duplicates in a scene, and linking them: nothing moves, and what could be lost is left alone."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix


@pytest.fixture
def shown(blender: Any) -> Any:
    settings = bpy.context.window_manager.shape_google_duplicates
    settings.groups.clear()
    settings.scope, settings.similar, settings.min_similarity = "SCENE", False, 0.95
    return settings


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


@pytest.fixture
def preferences(addon: ModuleType) -> Iterator[Any]:
    """The add-on's preferences; the library is put back afterwards."""
    chosen = bpy.context.preferences.addons[addon.__name__].preferences
    before = chosen.library
    yield chosen
    chosen.library = before


def module(addon: ModuleType, name: str) -> Any:
    return importlib.import_module(f"{addon.__name__}.{name}")


def test_objects_that_share_a_mesh_are_no_duplicates(shown: Any) -> None:
    data = lump()
    for name in "abc":
        add(name, data, motion(ord(name)))
    assert find(shown) == {}
    assert "No duplicates" in shown.status


def test_copies_are_identical_however_they_were_moved(shown: Any) -> None:
    data = lump()
    order = np.random.default_rng(1).permutation(len(data.vertices))
    add("a", data, motion(1))
    add("copied", data.copy(), motion(2))
    add("applied", changed(data, motion(3)))
    add("reordered", changed(data, motion(4), order), motion(5))
    add("stranger", lump(seed=9))
    assert find(shown).keys() == {"IDENTICAL"}
    assert set(kinds(shown)["IDENTICAL"]) == {"a", "copied", "applied", "reordered"}
    assert shown.groups[0].linkable
    assert shown.groups[0].meshes == 4
    assert shown.groups[0].saving == f"{3 * len(data.polygons):,} faces"
    assert not shown.groups[0].chosen


def test_mirrored_and_stretched_ones_are_not(shown: Any) -> None:
    data = lump()
    add("a", data)
    add("mirrored object", data.copy(), Matrix.Scale(-1, 4, (1, 0, 0)))
    mirrored = changed(data, Matrix.Scale(-1, 4, (1, 0, 0)))
    mirrored.flip_normals()
    add("mirrored mesh", mirrored)
    add("stretched", data.copy(), Matrix.Scale(1.5, 4, (0, 0, 1)))
    groups = find(shown)
    # Both mirrored ones look alike, but for the corners at which their polygons begin.
    assert {frozenset(members) for members in groups.values()} <= {
        frozenset({"mirrored object", "mirrored mesh"})
    }


def test_scaled_ones_are_named_with_their_factor(shown: Any) -> None:
    data = lump()
    add("a", data)
    add("a again", data.copy(), motion(1))
    add("inches", changed(data, motion(2, 2.54)))
    add("inches again", changed(data, motion(3, 2.54)))
    found = find(shown)
    assert [group.kind for group in shown.groups].count("IDENTICAL") == 2
    scaled = next(group for group in shown.groups if group.kind == "SCALED")
    assert found["SCALED"] == ["a", "inches"]
    assert scaled.members[1].scale == pytest.approx(2.54, rel=1e-5)


@pytest.mark.parametrize(
    ("what", "note"),
    [
        ("uv", "UV map"),
        ("material", "materials"),
        ("groups", "vertex groups"),
        ("smooth", "sharp_face"),
        ("attribute", "attribute 'paint'"),
        ("seam", "seams"),
        ("property", "custom properties"),
    ],
)
def test_other_data_is_told_apart_and_not_linked(shown: Any, what: Any, note: Any) -> None:
    data = lump()
    first, second = add("a", data), add("b", data.copy(), motion(1))
    other = second.data
    if what == "uv":
        other.uv_layers[0].data[5].uv.x += 0.1
    elif what == "material":
        other.materials.append(bpy.data.materials.new("red"))
    elif what == "groups":
        second.vertex_groups.new(name="left").add([1, 2], 0.5, "ADD")
    elif what == "smooth":
        for polygon in other.polygons:
            polygon.use_smooth = not polygon.use_smooth
    elif what == "attribute":
        other.attributes.new("paint", "FLOAT_COLOR", "POINT")
    elif what == "seam":
        other.edges[3].use_seam = True
    else:
        other["price"] = 12
    assert set(find(shown)["OTHER_DATA"]) == {"a", "b"}
    (group,) = shown.groups
    assert note in group.members[1].note
    assert not group.linkable
    with pytest.raises(RuntimeError, match="Choose at least one group"):
        link(shown)
    assert first.data != second.data


def test_equal_data_is_compared_behind_another_order(shown: Any) -> None:
    data = lump()
    first = add("a", data)
    first.vertex_groups.new(name="left").add(list(range(20)), 0.5, "ADD")
    order = np.random.default_rng(1).permutation(len(data.vertices))
    second = add("b", changed(data, motion(1), order))
    group = second.vertex_groups.new(name="left")
    group.add([int(np.flatnonzero(order == index)[0]) for index in range(20)], 0.5, "ADD")
    assert set(find(shown)["IDENTICAL"]) == {"a", "b"}
    group.add([int(np.flatnonzero(order == 3)[0])], 0.25, "REPLACE")
    assert find(shown).keys() == {"OTHER_DATA"}


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
    shown.groups[0].chosen = True
    assert bpy.ops.shape_google.link_duplicates() == {"FINISHED"}
    assert bpy.data.objects["b"].data == bpy.data.objects["b copy"].data  # the larger saving came first
    assert bpy.data.objects["a"].data != bpy.data.objects["a copy"].data
    bpy.data.objects["a copy"].data.vertices[0].co.x += 1
    shown.groups[1].chosen = True
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


def test_select_takes_the_group_and_nothing_else(shown: Any) -> None:
    data = lump()
    a, b, other = add("a", data), add("b", data.copy(), motion(1)), add("other", lump(seed=3))
    other.select_set(True)
    find(shown)
    assert bpy.ops.shape_google.select_duplicates(index=0) == {"FINISHED"}
    assert set(bpy.context.selected_objects) == {a, b}
    assert bpy.context.view_layer.objects.active.name == shown.groups[0].name
    with pytest.raises(RuntimeError, match="no group 7"):
        bpy.ops.shape_google.select_duplicates(index=7)


def test_similar_shapes_are_listed_to_select_only(shown: Any) -> None:
    shown.similar = True
    data = lump(subdivisions=3)
    points = np.array([vertex.co for vertex in data.vertices])
    near = data.copy()
    for vertex, point in zip(near.vertices, points, strict=True):
        vertex.co = point * (1 + 0.05 * math.sin(9 * point[0]))
    add("a", data)
    add("near", near)
    bpy.ops.mesh.primitive_torus_add(location=(9, 0, 0))
    found = find(shown)
    assert found == {"SIMILAR": ["a", "near"]}
    assert 0.95 <= shown.groups[0].members[1].similarity < 1
    assert not shown.groups[0].linkable


def test_a_library_is_listed_and_its_shapes_here_can_be_selected(
    addon: ModuleType, shown: Any, tmp_path: Path, preferences: Any
) -> None:
    from shapegoogle_core import Library

    scene = module(addon, "scene.meshes")
    blend = tmp_path / "scene.blend"
    first = add("a", lump())
    second = add("b", lump())
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    path = tmp_path / "shapes.sglib"
    with Library.open(path) as library:
        for item in (first, second):
            library.add(scene.base_mesh(item), source=str(blend), object_name=item.name)
    preferences.library = str(path)
    shown.scope = "LIBRARY"
    assert find(shown) == {"IDENTICAL": ["a", "b"]}
    assert not shown.groups[0].linkable
    assert bpy.ops.shape_google.select_duplicates() == {"FINISHED"}
    assert set(bpy.context.selected_objects) == {first, second}


def test_without_a_usable_library_it_says_so(
    addon: ModuleType, shown: Any, tmp_path: Path, preferences: Any
) -> None:
    shown.scope = "LIBRARY"
    preferences.library = str(tmp_path / "none.sglib")
    with pytest.raises(RuntimeError, match="Index a library first"):
        bpy.ops.shape_google.find_duplicates()
    broken = tmp_path / "broken.sglib"
    broken.write_text("no library")
    preferences.library = str(broken)
    with pytest.raises(RuntimeError, match=r"broken\.sglib"):
        bpy.ops.shape_google.find_duplicates()


def test_objects_without_extent_are_left_out_and_named(addon: ModuleType, shown: Any) -> None:
    empty = bpy.data.meshes.new("empty")
    flat = lump()
    add("nothing", empty)
    add("flattened", flat, Matrix.Diagonal((1, 1, 0, 1)))
    found = module(addon, "duplicates.groups").collect_shapes(bpy.context, bpy.context.scene.objects)
    assert set(found.skipped) == {"nothing", "flattened"}
    assert find(shown) == {}


def test_in_a_scene_of_200_objects_only_near_ones_are_compared(
    addon: ModuleType, shown: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    for index in range(200):
        data = lump(seed=index // 4, subdivisions=3)
        order = np.random.default_rng(index).permutation(len(data.vertices)) if index % 4 == 3 else None
        add(f"object {index:03}", changed(data, motion(index), order))
    groups = module(addon, "duplicates.groups")
    compare = groups.congruence
    compared = []

    def count(*meshes: Any) -> Any:
        compared.append(meshes)
        return compare(*meshes)

    monkeypatch.setattr(groups, "congruence", count)
    find(shown)
    # Each of 150 copies with its first and few others, of 19,900 pairs in all.
    assert 150 <= len(compared) <= 500
    assert sorted(group.meshes for group in shown.groups) == [4] * 50
