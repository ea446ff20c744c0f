# SPDX-License-Identifier: MIT
"""A fresh Blender for every test, with the add-on enabled; run these tests with a Python that has bpy."""

from __future__ import annotations

import shutil
import sqlite3
import sys
from contextlib import closing
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest

from shapegoogle_core import Library
from tests.addon.shapes import add_folder, lumpy


def addon_name() -> str:
    """Module of the add-on: the extension where it is installed, the repository's folder elsewhere."""
    installed = [
        name for name in sys.modules if name.startswith("bl_ext.") and name.endswith(".shape_google")
    ]
    return installed[0] if installed else "blender_addon"


def to_point_cloud() -> bool:
    """Turn the selected meshes into Blender's own point clouds, where it can (not yet in 4.2)."""
    try:
        return bool(bpy.ops.object.convert(target="POINTCLOUD") == {"FINISHED"})
    except TypeError:
        return False


@pytest.fixture(scope="session")
def addon() -> ModuleType:
    """The add-on's package, enabled."""
    import addon_utils  # on the path only once bpy is imported

    name = addon_name()
    module: ModuleType | None = addon_utils.enable(name, default_set=True)
    assert module is not None, f"{name} cannot be enabled"
    return module


@pytest.fixture(autouse=True)
def blender(addon: ModuleType, tmp_path: Path) -> Any:
    """An empty scene, no results, and a library of its own that is not there yet, for every test."""
    if bpy.context.object is not None and bpy.context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    # A collection that a test has left, perhaps excluded or active, would hide what the next one adds.
    layer = bpy.context.view_layer
    layer.active_layer_collection = layer.layer_collection
    bpy.context.scene.frame_set(1)
    for collection in (
        bpy.data.collections,
        bpy.data.objects,
        bpy.data.meshes,
        bpy.data.pointclouds,
        bpy.data.armatures,
        bpy.data.images,
    ):
        for block in list(collection):
            collection.remove(block)
    preferences = bpy.context.preferences.addons[addon.__name__].preferences
    preferences.library = str(tmp_path / "shapes.sglib")
    preferences.folders.clear()
    preferences.use_asset_libraries, preferences.use_scene = False, False
    preferences.objects, preferences.jobs, preferences.model = "ALL", 1, "DEFAULT"
    preferences.frames = ""
    session = bpy.context.window_manager.shape_google
    for name in (
        "matches",
        "examples",
        "several",
        "asked",
        "errors",
        "least_similarity",
        "use_size",
        "size_tolerance",
        "source",
        "text",
        "collapse",
        "top",
        "opened",
        "versions",
        "active_version",
    ):
        session.property_unset(name)
    return bpy


@pytest.fixture
def preferences(addon: ModuleType) -> Any:
    return bpy.context.preferences.addons[addon.__name__].preferences


@pytest.fixture
def session() -> Any:
    return bpy.context.window_manager.shape_google


@pytest.fixture(scope="session")
def made_once() -> dict[str, Path]:
    """Files that are made for the first test that needs them, and copied for the others."""
    return {}


@pytest.fixture
def folder(blender: Any, tmp_path: Path, tmp_path_factory: Any, made_once: dict[str, Path]) -> Path:
    """A folder of three .blend files with a shape each, a mesh file, and one that is broken."""
    if "folder" not in made_once:
        folder = made_once["folder"] = tmp_path_factory.mktemp("made") / "assets"
        folder.mkdir()
        for seed, name in enumerate(["apple", "pear", "plum"]):
            item = lumpy(name.title(), seed)
            bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"), copy=True)
            if name == "plum":
                bpy.ops.wm.obj_export(filepath=str(folder / "nut.obj"))
            bpy.data.objects.remove(item)
        (folder / "broken.blend").write_bytes(b"no Blender file")
    return Path(shutil.copytree(made_once["folder"], tmp_path / "assets"))


@pytest.fixture
def indexed(folder: Path, preferences: Any, made_once: dict[str, Path]) -> Path:
    """The folder, and a library of it."""
    add_folder(preferences, folder)
    library = preferences.library_path()
    if "library" not in made_once:
        assert bpy.ops.shape_google.index_library() == {"FINISHED"}
        made_once["indexed"] = folder
        made_once["library"] = made_once["folder"].with_name("shapes.sglib")
        copy_library(library, made_once["library"])
        return folder
    copy_library(made_once["library"], library)
    with Library.open(library) as opened:
        opened.move(made_once["indexed"], folder)
    return folder


def copy_library(source: Path, target: Path) -> None:
    """Copy a library that another process may have open."""
    with closing(sqlite3.connect(source)) as old, closing(sqlite3.connect(target)) as new:
        old.backup(new)
