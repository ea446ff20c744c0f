# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose a match in the gallery, and turn its pages."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import IntProperty

from ..state import session_of
from ..translation import tr
from . import pictures
from .labels import tooltip
from .on_match import shown_lines

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_OT_choose_match(bpy.types.Operator):
    """Choose a match."""

    bl_idname = "shape_google.choose_match"
    bl_label = "Choose Match"
    bl_options = {"INTERNAL"}

    index: IntProperty(options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context: Any, properties: Any) -> str:
        """Return the tooltip of a match."""
        lines, _ = shown_lines(session_of(context))
        if not 0 <= properties.index < len(lines):
            return tr("Choose this match")
        return tooltip(lines[properties.index])

    def execute(self, context: Any) -> set[str]:
        """Choose it."""
        session = session_of(context)
        lines, _ = shown_lines(session)
        if not 0 <= self.index < len(lines):
            return {"CANCELLED"}
        if session.opened >= 0:
            session.active_version = self.index
        else:
            session.active_match = self.index
        return {"FINISHED"}


class SHAPEGOOGLE_OT_turn_page(bpy.types.Operator):
    """Show other matches."""

    bl_idname = "shape_google.turn_page"
    bl_label = "Show More Matches"
    bl_description = "Show the next or the previous matches"
    bl_options = {"INTERNAL"}

    page: IntProperty(min=0, options={"SKIP_SAVE"})

    def execute(self, context: Any) -> set[str]:
        """Show them."""
        session_of(context).page = self.page
        return {"FINISHED"}


register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_choose_match, SHAPEGOOGLE_OT_turn_page)
)


def unregister() -> None:
    """Unregister the operators and remove the pictures."""
    _unregister()
    pictures.clear()
