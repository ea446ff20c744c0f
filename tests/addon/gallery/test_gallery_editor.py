# SPDX-License-Identifier: MIT
"""The large gallery without a window: placing matches, comparing them, and what clears them."""

from __future__ import annotations

import importlib
import io
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest
from mathutils import Vector
from PIL import Image

from tests.addon.shapes import lumpy, open_source


@pytest.fixture
def found(indexed: Path, session: Any) -> Any:
    """The matches of a shape that is in the library."""
    lumpy("Query", 1)
    session.collapse = False
    assert bpy.ops.shape_google.find_similar() == {"FINISHED"}
    return session


def low_middle(item: Any) -> tuple[float, ...]:
    bpy.context.view_layer.update()
    corners = [item.matrix_world @ Vector(corner) for corner in item.bound_box]
    low = [min(corner[axis] for corner in corners) for axis in range(3)]
    high = [max(corner[axis] for corner in corners) for axis in range(3)]
    return (low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]


def test_a_match_is_placed_where_it_is_dropped(found: Any) -> None:
    for index, line in enumerate(found.matches):
        if line.object_name == "Plum":
            bpy.ops.shape_google.choose_match(index=index)
    assert bpy.ops.shape_google.drop_match(location=(3, -2, 0.5)) == {"FINISHED"}
    (item,) = bpy.context.selected_objects
    assert item.name == "Plum"
    assert low_middle(item) == pytest.approx((3, -2, 0.5), abs=1e-4)


def test_what_is_in_the_scene_is_copied_with_the_same_data(blender: Any, session: Any) -> None:
    item = lumpy("Here", 1)
    item.rotation_euler.z = 0.5
    match = session.matches.add()
    match.name = match.object_name = "Here"
    match.source = open_source()
    session.active_match = 0
    before = tuple(item.location)
    assert bpy.ops.shape_google.drop_match(location=(5, 0, 1)) == {"FINISHED"}
    (copy,) = bpy.context.selected_objects
    assert copy != item
    assert copy.data == item.data
    assert low_middle(copy) == pytest.approx((5, 0, 1), abs=1e-4)
    assert copy.rotation_euler.z == pytest.approx(0.5)
    assert tuple(item.location) == before


def test_a_match_goes_into_the_scene_where_the_active_collection_is_closed(
    blender: Any, session: Any, addon: ModuleType, tmp_path: Path
) -> None:
    closed = bpy.data.collections.new("Closed")
    bpy.context.scene.collection.children.link(closed)
    path = tmp_path / "other.blend"
    bpy.data.libraries.write(str(path), {closed})
    with bpy.data.libraries.load(str(path), link=True) as (_, wanted):
        wanted.collections = ["Closed"]
    linked = wanted.collections[0]
    bpy.context.scene.collection.children.link(linked)
    layer = bpy.context.view_layer
    lumpy("Here", 1)
    match = session.matches.add()
    match.name = match.object_name = "Here"
    match.source = open_source()
    session.active_match = 0
    for child in layer.layer_collection.children:
        layer.active_layer_collection = child
        assert bpy.context.collection in (closed, linked)
        child.exclude = bpy.context.collection == closed
        assert bpy.ops.shape_google.drop_match(location=(5, 0, 1)) == {"FINISHED"}
        (copy,) = bpy.context.selected_objects
        assert list(copy.users_collection) == [bpy.context.scene.collection]


def test_a_damaged_picture_is_none(addon: ModuleType) -> None:
    pictures = importlib.import_module(f"{addon.__name__}.gallery.pictures")
    content = io.BytesIO()
    Image.new("RGBA", (64, 64), (255, 0, 0, 255)).save(content, "PNG")
    png = content.getvalue()
    assert pictures.pixels_of(png).shape == (64, 64, 4)
    for damaged in (b"", b"no picture", png[:60], png[:16] + b"\xff" * 4 + png[20:]):
        assert pictures.pixels_of(damaged) is None


def test_a_place_is_on_a_surface_else_on_the_floor_else_in_the_plane_of_the_cursor(
    addon: ModuleType, blender: Any
) -> None:
    place = importlib.import_module(f"{addon.__name__}.gallery.editor.place")
    context = bpy.context
    bpy.ops.mesh.primitive_cube_add(size=2, location=(0, 0, 1))
    context.view_layer.update()
    down = Vector((0, 0, -1))
    assert tuple(place.along_ray(context, Vector((0.3, 0.2, 9)), down, 100)) == pytest.approx((0.3, 0.2, 2))
    assert tuple(place.along_ray(context, Vector((5, 5, 9)), down, 100)) == pytest.approx((5, 5, 0))
    context.scene.cursor.location = (0, 7, 3)
    level = Vector((0, 1, 0))
    seen = place.along_ray(context, Vector((40, -9, 4)), level, 100)
    assert tuple(seen) == pytest.approx((40, 7, 4))
    # The floor is behind the viewer, or farther than anything that is shown.
    up = Vector((0, 0, 1))
    assert place.along_ray(context, Vector((40, 0, 2)), up, 100).z == pytest.approx(3)
    far = Vector((0, 0.9950, -0.0998)).normalized()
    assert place.along_ray(context, Vector((40, -9, 90)), far, 100).z > 1


def test_compare_reports_the_distance_in_the_units_of_the_scene(
    found: Any, addon: ModuleType, capfd: pytest.CaptureFixture[str]
) -> None:
    operators = importlib.import_module(f"{addon.__name__}.gallery.compare.operators")
    assert found.active_match == 0
    assert bpy.ops.shape_google.compare_match() == {"FINISHED"}
    assert "95 % of the surface within" in capfd.readouterr().out
    units = bpy.context.scene.unit_settings
    assert operators.length_text(bpy.context, 0.012) == "1.2 cm"
    units.system = "NONE"
    assert operators.length_text(bpy.context, 0.012) == "0.012"
    units.system = "METRIC"


def test_nothing_is_compared_without_a_search(blender: Any, session: Any) -> None:
    session.matches.add().name = "Left"
    session.active_match = 0
    assert not bpy.ops.shape_google.compare_match.poll()


def test_matches_survive_undo_saving_and_modes_but_not_another_file(found: Any, tmp_path: Path) -> None:
    names = [match.name for match in found.matches]

    def kept() -> list[str]:
        return [match.name for match in bpy.context.window_manager.shape_google.matches]

    bpy.ops.ed.undo_push(message="One")
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.ed.undo_push(message="Two")
    bpy.ops.ed.undo()
    bpy.context.view_layer.objects.active = bpy.data.objects["Query"]
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "own.blend"))
    assert kept() == names
    bpy.ops.wm.revert_mainfile()
    assert kept() == names
    bpy.ops.wm.read_homefile(use_empty=True)
    assert kept() == []
    assert not bpy.ops.shape_google.compare_match.poll()
