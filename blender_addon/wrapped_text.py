# SPDX-License-Identifier: GPL-3.0-or-later
"""Long texts in narrow panels."""

from __future__ import annotations

from typing import Any

__all__ = ["wrapped"]


def wrapped(layout: Any, text: str, context: Any) -> None:
    """Lay out a text in as many lines as the region's width asks for.

    Parameters
    ----------
    layout : bpy.types.UILayout
    text : str
    context : bpy.types.Context
    """
    # About seven pixels for a letter, at the user's scale of the interface.
    width = getattr(context.region, "width", 300)
    letters = max(20, int(width / (7.0 * context.preferences.system.ui_scale)) - 6)
    column = layout.column(align=True)
    column.scale_y = 0.8
    words = text.split(" ")
    line = ""
    for word in words:
        while len(word) > letters:  # a path has no spaces
            room = letters - len(line) - 1 if line else letters
            if room < 8:
                column.label(text=line)
                line, room = "", letters
            column.label(text=f"{line} {word[:room]}".strip())
            line, word = "", word[room:]
        if line and len(line) + 1 + len(word) > letters:
            column.label(text=line)
            line = word
        else:
            line = f"{line} {word}".strip()
    if line:
        column.label(text=line)
