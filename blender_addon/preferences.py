# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user chooses once: where libraries are kept, how many workers, limits, the model."""

from __future__ import annotations

import bpy

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_preferences(bpy.types.AddonPreferences):
    """Preferences of the add-on."""

    bl_idname = __package__


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_preferences,))
