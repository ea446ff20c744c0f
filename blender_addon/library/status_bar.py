# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress and results of background work in Blender's status bar, wherever the sidebar is."""

from __future__ import annotations

from typing import Any

import bpy

from .. import state
from ..progress_bar import progress_bar
from ..state import session_of
from ..translation import tr

__all__ = ["redraw_status_bar", "register", "tell", "unregister"]


# In units of the interface: enough for a sentence.
WIDTH = 18
# How long a result is shown, as Blender shows reports of operators.
SECONDS_OF_TELLING = 8.0


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
    elif session.told:
        self.layout.label(text=_with_name(session.told), translate=False, icon="INFO")


def tell(context: Any, text: str) -> None:
    """Say for a while what was done; an operator that works in the background cannot report it any more.

    Parameters
    ----------
    context : bpy.types.Context
    text : str
        A sentence.
    """
    session_of(context).told = text
    redraw_status_bar()

    def forget() -> None:
        if state.is_registered() and session_of(bpy.context).told == text:
            session_of(bpy.context).told = ""
            redraw_status_bar()

    bpy.app.timers.register(forget, first_interval=SECONDS_OF_TELLING, persistent=True)


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
