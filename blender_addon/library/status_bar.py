# SPDX-License-Identifier: GPL-3.0-or-later
"""The progress of indexing and searching in Blender's status bar, wherever the sidebar is."""

from __future__ import annotations

from typing import Any

import bpy

from ..progress_bar import progress_bar
from ..state import session_of
from ..translation import tr

__all__ = ["redraw_status_bar", "register", "unregister"]


# In units of the interface: enough for a sentence.
WIDTH = 18


def _with_name(text: str) -> str:
    return f"Shape Google: {text}"


def _draw(self: Any, context: Any) -> None:
    session = session_of(context)
    if session.indexing:
        row = self.layout.row()
        row.ui_units_x = WIDTH
        progress_bar(row, session, "percent", _with_name(session.brief_progress or tr("indexing")))
        row.operator("shape_google.cancel_indexing", text="", icon="X", emboss=False)
    elif session.checking:
        row = self.layout.row()
        row.ui_units_x = WIDTH
        text = tr("Shape Google: {progress}").format(progress=session.check_status)
        progress_bar(row, session, "check_percent", text)
        row.operator("shape_google.cancel_check", text="", icon="X", emboss=False)
    elif session.searching:
        self.layout.label(text=_with_name(tr("searching …")), translate=False, icon="VIEWZOOM")


def redraw_status_bar() -> None:
    """Have the status bars drawn again, unless an operator shows a text there that would be lost."""
    for window in bpy.context.window_manager.windows:
        if not len(window.modal_operators):
            with bpy.context.temp_override(window=window):
                window.workspace.status_text_set(None)


def register() -> None:
    """Add the progress to the status bar."""
    bpy.types.STATUSBAR_HT_header.append(_draw)


def unregister() -> None:
    """Remove it."""
    bpy.types.STATUSBAR_HT_header.remove(_draw)
