# SPDX-License-Identifier: MIT
"""A fresh Blender for every test, with the add-on enabled; run these tests with a Python that has bpy."""

from __future__ import annotations

import sys
from types import ModuleType

import bpy
import pytest


def addon_name() -> str:
    """Module of the add-on: the extension where it is installed, the repository's folder elsewhere."""
    installed = [
        name for name in sys.modules if name.startswith("bl_ext.") and name.endswith(".shape_google")
    ]
    return installed[0] if installed else "blender_addon"


@pytest.fixture(scope="session")
def addon() -> ModuleType:
    """The add-on's package, enabled."""
    import addon_utils  # on the path only once bpy is imported

    name = addon_name()
    module = addon_utils.enable(name, default_set=True)
    assert module is not None, f"{name} cannot be enabled"
    return module


@pytest.fixture(autouse=True)
def blender(addon: ModuleType) -> ModuleType:
    """An empty scene for every test."""
    if bpy.context.object is not None and bpy.context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for collection in (bpy.data.objects, bpy.data.meshes, bpy.data.armatures, bpy.data.images):
        for block in list(collection):
            collection.remove(block)
    return bpy
