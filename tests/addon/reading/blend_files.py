# SPDX-License-Identifier: MIT
"""Small .blend files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy


def save(path: Path) -> Path:
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def add(name: str, **options: object) -> Any:
    bpy.ops.mesh.primitive_monkey_add(**options)
    bpy.context.object.name = name
    return bpy.context.object
