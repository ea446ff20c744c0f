# SPDX-License-Identifier: MIT
"""Collections and instances in the gallery: what they are, selecting and appending them as one."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest

from shapegoogle_core.library.evidence import KINDS
from shapegoogle_core.library.origin import SHAPE_TYPES
from tests.addon.reading.every_sort import make_library
from tests.addon.shapes import open_source


@pytest.fixture
def module(addon: ModuleType) -> Any:
    return lambda name: importlib.import_module(f"{addon.__name__}.{name}")


def choose(name: str, shape_type: str, source: str) -> Any:
    session = bpy.context.window_manager.shape_google
    match = session.matches.add()
    match.name = match.object_name = name
    match.shape_type, match.source = shape_type, source
    session.active_match = len(session.matches) - 1
    return match


def selected() -> set[str]:
    return {item.name for item in bpy.context.selected_objects}


def test_a_collection_is_appended_and_linked_as_one(tmp_path: Path) -> None:
    path = str(make_library(tmp_path))
    bpy.ops.wm.read_homefile(use_empty=True)
    choose("Lamp", "collection", path)
    assert bpy.ops.shape_google.append_match() == {"FINISHED"}
    assert selected() == {"Cylinder", "Shade"}
    foot, shade = bpy.data.objects["Cylinder"], bpy.data.objects["Shade"]
    assert (shade.matrix_world.translation - foot.matrix_world.translation).z == pytest.approx(2)
    bpy.ops.wm.read_homefile(use_empty=True)
    choose("Lamp", "collection", path)
    assert bpy.ops.shape_google.link_match() == {"FINISHED"}
    (item,) = bpy.context.selected_objects
    assert item.instance_collection.name == "Lamp"
    choose("Lost", "collection", path)
    with pytest.raises(RuntimeError, match="no collection 'Lost' any more"):
        bpy.ops.shape_google.append_match()
    bpy.ops.wm.read_homefile(use_empty=True)


def test_what_an_instance_shows_is_selected_with_it(tmp_path: Path, module: Any) -> None:
    make_library(tmp_path)
    here = open_source()
    finding = module("gallery.finding")
    match = choose("Lamp", "collection", here)
    assert bpy.ops.shape_google.select_match(all=True) == {"FINISHED"}
    assert selected() == {"Cylinder", "Shade", "Lamp 2"}
    # An object that is in no scene, only in the collection that others show.
    match = choose("Seat", "object", here)
    finding.find_objects(bpy.context, [match])
    assert match.in_scene
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    assert selected() <= {"Chair A", "Chair B", "Chair C", "Row"}
    match = choose("Forest", "scatter", here)
    assert bpy.ops.shape_google.select_match() == {"FINISHED"}
    assert selected() == {"Forest"}


def test_the_tooltip_says_what_a_match_is(module: Any) -> None:
    match = choose("Cube.003", "collection", "/props/oak.blend")
    match.title, match.tags, match.catalog, match.frame = "oak", "wood, door", "Props/Doors", "10"
    match.placement_count = 3
    name, where, what, *_ = module("gallery.labels").tooltip(match).split("\n")
    assert (name, where) == ("oak", "Cube.003 in /props/oak.blend")
    assert what == "Collection, shown 3 times, frame 10, catalog Props/Doors, tags wood, door"


def test_filters_of_the_gallery(session: Any, module: Any) -> None:
    filters, properties = module("gallery.filters"), module("gallery.properties")
    listed = {item[0] for item in properties._TYPES}
    assert listed == {"ANY", *SHAPE_TYPES}
    assert {item[0] for item in properties._EVIDENCE} == {"ANY", *KINDS}
    names = ("shape_type", "tag", "catalog", "least_faces", "most_faces", "evidence")
    assert not filters.is_filtered(session)
    try:
        session.shape_type, session.tag, session.catalog = "collection", " wood ", "Props/"
        session.least_faces, session.most_faces, session.evidence = 900, 10, "scaled"
        where = filters.conditions(session)
        assert filters.is_filtered(session)
    finally:
        for name in names:
            session.property_unset(name)
    assert (where.shape_type, where.tag, where.catalog) == ("collection", "wood", "Props")
    assert (where.faces, where.kind) == ((10, 900), "scaled")
