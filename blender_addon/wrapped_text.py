# SPDX-License-Identifier: GPL-3.0-or-later
"""Long texts in narrow panels: in a fixed number of lines, the whole text in the tooltip of a button."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import StringProperty

__all__ = ["fixed_text", "register", "split_lines", "unregister"]

# Pixels that a letter and the margins of a panel take, at a scale of the interface of 1.
LETTER, MARGIN = 7.0, 60.0
LINE_HEIGHT = 0.8
POPUP_LETTERS = 80


def fixed_text(layout: Any, text: str, context: Any, lines: int = 2) -> None:
    """Lay out a text in a number of lines that does not depend on it, so that nothing below moves.

    Parameters
    ----------
    layout : bpy.types.UILayout
    text : str
        If it is too long for the lines, the end is left out; a button beside them shows all of it.
    context : bpy.types.Context
    lines : int, optional
        Number of lines, also for a shorter text or none.
    """
    width = getattr(context.region, "width", 300) / context.preferences.system.ui_scale
    letters = max(20, int((width - MARGIN) / LETTER))
    whole = split_lines(text, letters)
    shown = whole[:lines]
    if len(whole) > lines:
        shown[-1] = f"{shown[-1][: letters - 1]}…"
    row = layout.row(align=True)
    column = row.column(align=True)
    column.scale_y = LINE_HEIGHT
    for line in [*shown, *[""] * (lines - len(shown))]:
        column.label(text=line, translate=False)
    side = row.column()
    side.enabled = len(whole) > lines
    side.operator("shape_google.show_text", text="", icon="INFO", emboss=False).text = text


def split_lines(text: str, letters: int) -> list[str]:
    """Split a text into lines, at spaces where possible.

    Parameters
    ----------
    text : str
    letters : int
        Longest line.

    Returns
    -------
    lines : list of str
        None for an empty text.
    """
    lines: list[str] = []
    line = ""
    for word in text.split():
        rest = word
        while len(rest) > letters:  # a path has no spaces
            room = letters - len(line) - 1 if line else letters
            if room < 8:
                lines.append(line)
                line, room = "", letters
            lines.append(f"{line} {rest[:room]}".strip())
            line, rest = "", rest[room:]
        if line and len(line) + 1 + len(rest) > letters:
            lines.append(line)
            line = rest
        else:
            line = f"{line} {rest}".strip()
    return [*lines, line] if line else lines


class SHAPEGOOGLE_OT_show_text(bpy.types.Operator):
    """Show a text that was shortened."""

    bl_idname = "shape_google.show_text"
    bl_label = "Show Text"
    bl_options = {"INTERNAL"}

    text: StringProperty(options={"SKIP_SAVE"})

    @classmethod
    def description(cls, _context: Any, properties: Any) -> str:
        """Return the whole text as the tooltip."""
        return str(properties.text)

    def execute(self, context: Any) -> set[str]:
        """Show it in a window of its own below the pointer."""
        lines = split_lines(self.text, POPUP_LETTERS)

        def draw(menu: Any, _context: Any) -> None:
            for line in lines:
                menu.layout.label(text=line, translate=False)

        context.window_manager.popup_menu(draw)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_OT_show_text,))
