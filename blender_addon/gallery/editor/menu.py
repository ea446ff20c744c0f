# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu of a picture in the gallery, and the sidebar of the gallery."""

from __future__ import annotations

from typing import Any

import bpy

from ...library.present import follow
from ...state import session_of
from ...translation import OWN_CONTEXT
from ...wrapped_text import fixed_text
from .. import panel
from ..on_match import active_match
from .area import is_gallery

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_MT_match(bpy.types.Menu):
    """What can be done with the chosen match."""

    bl_label = "Match"
    # Blender's own German for this word means that two things agree.
    bl_translation_context = OWN_CONTEXT

    def draw(self, context: Any) -> None:
        """Lay the menu out; other features append their entries."""
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        for name, icon in panel.BUTTONS:
            layout.operator(f"shape_google.{name}_match", icon=icon)
        layout.operator("shape_google.transfer_match", icon="MOD_DATA_TRANSFER")
        layout.separator()
        session, match = session_of(context), active_match(context)
        panel.draw_versions(layout, session, match)
        layout.operator("shape_google.mark_example", text="More Like This", icon="ADD").unlike = False
        layout.operator("shape_google.mark_example", text="Not Like This", icon="REMOVE").unlike = True


class SHAPEGOOGLE_PT_gallery(bpy.types.Panel):
    """The search and the chosen match, beside the pictures."""

    bl_label = "Search"
    bl_translation_context = OWN_CONTEXT
    bl_category = "Shape Google"
    bl_space_type = "NODE_EDITOR"
    bl_region_type = "UI"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that the area is a gallery."""
        return is_gallery(context.area)

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout, session = self.layout, session_of(context)
        follow(context)
        row = layout.row(align=True)
        row.scale_y = 1.3
        row.operator("shape_google.find_similar", icon="VIEWZOOM")
        row.operator("shape_google.cancel_search", text="", icon="X")
        fixed_text(layout, session.answer, context)
        layout.prop(session, "text", text="", icon="VIEWZOOM")
        layout.prop(session, "picture_size", slider=True)
        panel.draw_match(layout, session, active_match(context))


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_MT_match, SHAPEGOOGLE_PT_gallery))
