# SPDX-License-Identifier: MIT
"""Shapes, folders and sources for tests of the add-on."""

from __future__ import annotations

import hashlib
import importlib
from pathlib import Path
from typing import Any

import bpy
import numpy as np


def lumpy(name: str, seed: int, subdivisions: int = 4) -> Any:
    """A lumpy ellipsoid, another one for each seed."""
    random = np.random.default_rng(seed)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions)
    item = bpy.context.object
    item.name = name
    points = np.empty((len(item.data.vertices), 3), np.float32)
    item.data.vertices.foreach_get("co", points.ravel())
    centers = random.standard_normal((4, 3))
    centers /= np.linalg.norm(centers, axis=1, keepdims=True)
    points *= (1 + np.exp(-6 * (1 - points @ centers.T)) @ random.uniform(0, 0.7, 4))[:, None]
    points *= random.uniform(0.6, 1.8, 3)
    item.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    item.data.update()
    return item


def open_source() -> str:
    """Source that the open file is in a library."""
    from tests.addon.conftest import addon_name

    source: str = importlib.import_module(f"{addon_name()}.library.open_file").open_source()
    return source


def add_folder(preferences: Any, folder: Path) -> None:
    assert bpy.ops.shape_google.add_folder(directory=str(folder)) == {"FINISHED"}
    assert [item.path for item in preferences.folders] == [str(folder)]


def digests(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()}
