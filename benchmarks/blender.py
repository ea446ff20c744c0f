# SPDX-License-Identifier: MIT
"""The add-on of this repository, switched on in a Python that has Blender's bpy module."""

from __future__ import annotations

from types import ModuleType

__all__ = ["enable_addon"]


def enable_addon() -> ModuleType:
    """Switch on the add-on in the folder `blender_addon` of this repository.

    Blender's saved preferences are not touched.

    Returns
    -------
    addon : module

    Raises
    ------
    RuntimeError
        If Blender cannot enable it.
    """
    import bpy  # noqa: F401, I001 - puts the next one on the path
    import addon_utils

    addon: ModuleType | None = addon_utils.enable("blender_addon", default_set=True)
    if addon is None:
        raise RuntimeError("Blender cannot enable the add-on of this repository; the lines above say why")
    return addon
