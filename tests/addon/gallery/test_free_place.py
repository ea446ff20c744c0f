# SPDX-License-Identifier: MIT
"""Append places a match at the cursor, but not inside the query or earlier matches; an asset stays one."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest


def add(name: str) -> Any:
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.name = name
    return bpy.context.object


@pytest.fixture
def asset(blender: Any, addon: ModuleType, tmp_path: Path) -> Iterator[Path]:
    """A file with an asset, which is the match that is chosen."""
    bpy.ops.wm.read_homefile(use_empty=True)
    item = add("Box")
    item.asset_mark()
    item.asset_data.tags.new("crate")
    path = tmp_path / "box.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    session = bpy.context.window_manager.shape_google
    session.matches.clear()
    match = session.matches.add()
    match.name = match.object_name = "Box"
    match.source = str(path)
    session.active_match = 0
    state = importlib.import_module(f"{addon.__name__}.state").current()
    state.gallery.placed.clear()
    state.search.searched = frozenset()
    yield path
    bpy.ops.wm.read_homefile(use_empty=True)


def sides(item: Any) -> tuple[float, float]:
    xs = [(item.matrix_world @ vertex.co).x for vertex in item.data.vertices]
    return min(xs), max(xs)


def test_beside_the_query_and_earlier_matches(asset: Path) -> None:
    query = add("Query")
    ends = [sides(query)[1]]
    for _ in range(3):
        assert bpy.ops.shape_google.append_match() == {"FINISHED"}
        low, high = sides(bpy.context.active_object)
        assert low > ends[-1]
        ends.append(high)
    assert sides(query) == (-1, 1)


def test_at_the_cursor_where_there_is_room(asset: Path) -> None:
    add("Query")
    bpy.context.scene.cursor.location = (0, 7, 2)
    bpy.ops.shape_google.append_match()
    placed = bpy.context.active_object
    assert placed.matrix_world.translation[:] == pytest.approx((0, 7, 3))


def test_an_asset_stays_one_unless_it_should_not(asset: Path) -> None:
    bpy.ops.shape_google.append_match()
    assert [tag.name for tag in bpy.context.active_object.asset_data.tags] == ["crate"]
    bpy.ops.shape_google.append_match(keep_asset=False)
    assert bpy.context.active_object.asset_data is None
