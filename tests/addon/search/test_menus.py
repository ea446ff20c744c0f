# SPDX-License-Identifier: MIT
"""Find Similar in context menus, with assets, curves, texts and what is instanced."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
import pytest

from shapegoogle_core.worker.assets import shape_of
from tests.addon.reading.every_sort import make_library


def test_menus_have_an_entry_as_long_as_it_is_on(addon: ModuleType) -> None:
    menus = importlib.import_module(f"{addon.__name__}.search.menus")
    for name, operator in menus._MENUS.items():
        assert menus._DRAW[operator] in getattr(bpy.types, name)._dyn_ui_initialize()
    menus.unregister()
    try:
        for name, operator in menus._MENUS.items():
            assert menus._DRAW[operator] not in getattr(bpy.types, name)._dyn_ui_initialize()
    finally:
        menus.register()


def test_curves_texts_and_scatters_are_queries(addon: ModuleType, tmp_path: Path) -> None:
    meshes = importlib.import_module(f"{addon.__name__}.scene.query")
    bpy.ops.wm.open_mainfile(filepath=str(make_library(tmp_path)))
    counts = {}
    for name in ("Rope", "Sign", "Hull", "Drop", "Chair A", "Forest", "Bricks", "Wheel"):
        bpy.ops.object.select_all(action="DESELECT")
        item = bpy.data.objects[name]
        item.select_set(True)
        bpy.context.view_layer.objects.active = item
        (mesh,) = meshes.query_meshes(bpy.context)
        assert mesh.name == name
        counts[name] = len(mesh.faces)
    tree = len(bpy.data.objects["Tree"].data.polygons)
    assert (counts["Forest"], counts["Bricks"], counts["Chair A"]) == (2 + 4 * tree, 4 * 12, 2 * 12)
    assert min(counts.values()) > 0
    item = bpy.data.objects["Bricks"]
    item.select_set(True)
    (mesh,) = [mesh for mesh in meshes.query_meshes(bpy.context, separate=True) if mesh.name == "Bricks"]
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(21)
    bpy.ops.wm.read_homefile(use_empty=True)


def test_an_asset_is_found_in_the_library(tmp_path: Path, preferences: Any) -> None:
    source = str(make_library(tmp_path))
    bpy.ops.wm.open_mainfile(filepath=source)
    preferences.use_scene = True
    assert bpy.ops.shape_google.index_library() == {"FINISHED"}
    library = preferences.library_path()
    shape = shape_of(library, source, "Lamp", is_collection=True)
    assert shape is not None
    assert shape[1] == "Lamp"
    twice = shape_of(library, source, "Wheel twice")
    assert twice is not None
    assert twice[1] == "Wheel"
    assert shape_of(library, source, "Lamp") is None
    assert shape_of(library, "elsewhere.blend", "Wheel") is None
    bpy.ops.wm.read_homefile(use_empty=True)
