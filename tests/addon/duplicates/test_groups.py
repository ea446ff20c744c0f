# SPDX-License-Identifier: MIT
"""Finding groups of duplicates in a scene."""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from tests.addon.duplicates.objects import add, changed, find, kinds, link, lump, module, motion


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
    assert shown.groups[0].saved_faces == 3 * len(data.polygons)
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


def test_similar_shapes_are_listed_to_select_only(shown: Any) -> None:
    shown.similar = True
    data = lump(subdivisions=3)
    points = np.array([vertex.co for vertex in data.vertices])
    near = data.copy()
    for vertex, point in zip(near.vertices, points, strict=True):
        vertex.co = point * (1 + 0.02 * math.sin(9 * point[0]))
    add("a", data)
    add("near", near)
    bpy.ops.mesh.primitive_torus_add(location=(9, 0, 0))
    found = find(shown)
    assert found == {"SIMILAR": ["a", "near"]}
    assert 0.95 <= shown.groups[0].members[1].similarity < 1
    assert not shown.groups[0].linkable


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
    compare = groups.congruence_steps
    compared = []

    def count(*meshes: Any) -> Any:
        compared.append(meshes)
        return compare(*meshes)

    monkeypatch.setattr(groups, "congruence_steps", count)
    find(shown)
    # Each of 150 copies with its first and few others, of 19,900 pairs in all.
    assert 150 <= len(compared) <= 500
    assert sorted(group.meshes for group in shown.groups) == [4] * 50
