# SPDX-License-Identifier: MIT
"""Fixtures of these tests."""

from __future__ import annotations

import importlib
from types import ModuleType
from typing import Any

import bpy
import pytest


@pytest.fixture(autouse=True)
def settings(blender: Any) -> Any:
    """Settings of the scene, each at its default."""
    chosen = bpy.context.scene.shape_google_painting
    for name in [entry.identifier for entry in chosen.bl_rna.properties]:
        if name not in ("name", "rna_type"):
            chosen.property_unset(name)
    return chosen


@pytest.fixture
def modules(addon: ModuleType) -> Any:
    """Access to the add-on's modules, whatever its package is called."""

    class Modules:
        def __getattr__(self, name: str) -> Any:
            home = "scene.meshes" if name == "scene" else f"signature.{name}"
            return importlib.import_module(f"{addon.__name__}.{home}")

    return Modules()
