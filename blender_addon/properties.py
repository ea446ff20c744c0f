# SPDX-License-Identifier: GPL-3.0-or-later
"""What panels show and operators fill: results on the window manager, painting settings on the scene."""

from __future__ import annotations

import bpy
from bpy.props import PointerProperty

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_PG_session(bpy.types.PropertyGroup):
    """State of this Blender session: results, progress, errors; never saved in a file."""


_register, _unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_session,))


def register() -> None:
    """Make the properties known to Blender."""
    _register()
    bpy.types.WindowManager.shape_google = PointerProperty(type=SHAPEGOOGLE_PG_session)


def unregister() -> None:
    """Take them back."""
    del bpy.types.WindowManager.shape_google
    _unregister()
