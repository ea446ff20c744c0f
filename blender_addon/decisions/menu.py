# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu of what can be decided about a match, or done with it in place of the selection."""

from __future__ import annotations

from typing import Any

import bpy

from ..translation import tr
from .operators import DECISIONS

__all__ = ["draw_match_menu", "register", "unregister"]


def draw_match_menu(layout: Any) -> None:
    """Draw the entries for the chosen match into a menu.

    Parameters
    ----------
    layout : bpy.types.UILayout
    """
    layout.operator_context = "INVOKE_DEFAULT"
    layout.operator("shape_google.replace_with_match", icon="UV_SYNC_SELECT")
    layout.separator()
    for kind, text, _, icon, _ in DECISIONS:
        layout.operator("shape_google.decide_match", text=tr(text), icon=icon).kind = kind


class SHAPEGOOGLE_MT_decide(bpy.types.Menu):
    """What is decided about the chosen match."""

    bl_label = "Decide"
    bl_description = "Replace the selection by the match, or remember what you decide about it"

    def draw(self, _context: Any) -> None:
        """Lay the menu out."""
        draw_match_menu(self.layout)


def _draw_entries(menu: Any, _context: Any) -> None:
    menu.layout.separator()
    draw_match_menu(menu.layout)


_register, _unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_MT_decide,))


def register() -> None:
    """Register the menu, and its entries in the context menu of the gallery."""
    _register()
    context_menu = getattr(bpy.types, "SHAPEGOOGLE_MT_match", None)
    if context_menu is not None:
        context_menu.append(_draw_entries)


def unregister() -> None:
    """Unregister the menu."""
    context_menu = getattr(bpy.types, "SHAPEGOOGLE_MT_match", None)
    if context_menu is not None:
        context_menu.remove(_draw_entries)
    _unregister()
