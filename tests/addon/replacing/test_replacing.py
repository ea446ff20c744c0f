# SPDX-License-Identifier: MIT
"""*Replace With Match*: the mesh changes; nothing else of the object does, and nothing is lost."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix

from tests.addon.duplicates.objects import add, farthest, in_world
from tests.addon.shapes import lumpy

PLACE = Matrix.Translation((3, -2, 1)) @ Euler((0.4, 0.2, 1.0)).to_matrix().to_4x4() @ Matrix.Scale(1.5, 4)


@pytest.fixture
def chosen(indexed: Path, session: Any) -> Callable[[Any, str], Any]:
    """Search with an object, choose a match, and select the object alone."""

    def choose(query: Any, name: str) -> Any:
        session.collapse = False
        for item in bpy.context.selected_objects:
            item.select_set(False)
        query.select_set(True)
        bpy.context.view_layer.objects.active = query
        assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
        names = [match.name for match in session.matches]
        assert bpy.ops.shape_google.choose_match(index=names.index(name)) == {"FINISHED"}
        return query

    return choose


def blocks() -> dict[str, set[str]]:
    """Names of all data of the file, by kind."""
    found: dict[str, set[str]] = {}
    for block in bpy.data.user_map():
        found.setdefault(type(block).__name__, set()).add(block.name)
    return found


def test_a_remeshed_object_gets_the_mesh_where_its_own_was(chosen: Any) -> None:
    query = lumpy("Query", 1)
    query.data.transform(Matrix.Scale(0.01, 4) @ Euler((1.5, 0, 0)).to_matrix().to_4x4())
    query.modifiers.new("Finer", "SUBSURF")
    query.matrix_world = PLACE @ Matrix.Scale(100, 4)
    child = add("Child", None)
    child.parent = query
    bpy.context.view_layer.update()
    before = in_world(query), query.matrix_world.copy(), child.matrix_world.copy()
    material = bpy.data.materials.new("Oak")
    query.data.materials.append(material)
    old = query.data
    there = blocks()
    chosen(query, "Pear")
    assert bpy.ops.shape_google.replace_with_match() == {"FINISHED"}
    assert query.data != old
    assert len(query.data.vertices) == 642
    extent = float(np.ptp(before[0], axis=0).max())
    away = np.linalg.norm(in_world(query)[:, None] - before[0], axis=2).min(axis=1)
    assert away.max() < 0.03 * extent
    assert query.matrix_world == before[1]
    assert child.matrix_world == before[2]
    # Nothing is lost: the modifier is off, and the old mesh kept.
    assert [modifier.show_viewport for modifier in query.modifiers] == [False]
    assert old.use_fake_user
    assert not len(query.data.materials)
    # Nothing but the mesh came along.
    now = blocks()
    assert now.pop("Mesh") == there.pop("Mesh") | {query.data.name}
    assert now == there


def test_objects_that_share_a_mesh_share_the_new_one(chosen: Any) -> None:
    query = lumpy("Query", 1)
    query.data.transform(Euler((0.5, 0, 0)).to_matrix().to_4x4())
    material = bpy.data.materials.new("Oak")
    query.data.materials.append(material)
    other, third = add("Other", query.data, PLACE), add("Third", query.data)
    before = in_world(other)
    chosen(query, "Pear")
    other.select_set(True)
    old = query.data
    assert bpy.ops.shape_google.replace_with_match(keep_materials=True) == {"FINISHED"}
    assert query.data == other.data != old
    assert third.data == old
    assert not old.use_fake_user
    assert farthest(in_world(other), before) < 1e-3
    assert [item.material_slots[0].material for item in (query, other)] == [material, material]
    assert not query.data.materials[0]  # at the objects, not at the new mesh


def test_another_shape_keeps_its_size(chosen: Any) -> None:
    query = lumpy("Query", 1)
    query.matrix_world = PLACE
    chosen(query, "Plum")
    assert bpy.ops.shape_google.replace_with_match(align=False, keep_mesh=False) == {"FINISHED"}
    points = np.array([vertex.co[:] for vertex in query.data.vertices])
    plum = lumpy("Plum again", 2)
    assert np.abs(points - [vertex.co[:] for vertex in plum.data.vertices]).max() < 1e-6
    assert np.allclose(query.matrix_world, PLACE, atol=1e-6)


def test_a_mesh_file_is_imported_for_it(chosen: Any) -> None:
    query = lumpy("Query", 2)
    query.matrix_world = PLACE
    before = in_world(query)
    objects = set(bpy.data.objects)
    chosen(query, "nut.obj")
    assert bpy.ops.shape_google.replace_with_match() == {"FINISHED"}
    assert farthest(in_world(query), before) < 1e-3
    assert set(bpy.data.objects) == objects
    assert bpy.context.selected_objects == [query]


def test_shape_keys_stay_with_the_old_mesh(chosen: Any) -> None:
    query = lumpy("Query", 1)
    query.shape_key_add(name="Basis")
    query.shape_key_add(name="Smile")
    old = query.data
    chosen(query, "Pear")
    assert bpy.ops.shape_google.replace_with_match() == {"FINISHED"}
    assert query.data.shape_keys is None
    assert old.use_fake_user
    assert [key.name for key in old.shape_keys.key_blocks] == ["Basis", "Smile"]


def test_what_cannot_be_replaced_is_left_and_named(chosen: Any) -> None:
    query = lumpy("Query", 1)
    pin = add("Pin", None)
    pin.parent, pin.parent_type = query, "VERTEX"
    old = query.data
    chosen(query, "Pear")
    there = blocks()
    with pytest.raises(RuntimeError, match="Left as it is: 'Query', since children hang on its vertices"):
        bpy.ops.shape_google.replace_with_match()
    assert query.data == old
    assert blocks() == there
    bpy.ops.object.select_all(action="DESELECT")
    assert not bpy.ops.shape_google.replace_with_match.poll()


def test_a_match_of_this_scene_is_shared(chosen: Any, preferences: Any) -> None:
    pear, query = lumpy("Pear here", 1), lumpy("Query", 1)
    pear.location = 5, 0, 0
    preferences.use_scene = True
    bpy.ops.shape_google.index_library()
    chosen(query, "Pear here")
    assert bpy.ops.shape_google.replace_with_match() == {"FINISHED"}
    assert query.data == pear.data
    assert tuple(pear.location) == (5, 0, 0)
    # Materials that are kept need a slot, which the object that has the mesh does not get.
    first = lumpy("First", 1)
    second = add("Second", first.data)
    oak = bpy.data.materials.new("Oak")
    first.data.materials.append(oak)
    bpy.ops.object.select_all(action="DESELECT")
    for item in (first, second):
        item.select_set(True)
    assert bpy.ops.shape_google.replace_with_match(align=False, keep_materials=True) == {"FINISHED"}
    assert first.data == second.data != pear.data
    assert [item.material_slots[0].material for item in (first, second)] == [oak, oak]
    assert not len(pear.material_slots)
