# SPDX-License-Identifier: GPL-3.0-or-later
"""The search field of the gallery: what is typed filters at once."""

from __future__ import annotations

from typing import Any

import bpy

from ... import state
from ...state import session_of
from ...translation import tr
from .area import redraw
from .operators import InGallery
from .typed_text import TypedText

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_OT_gallery_search(InGallery, bpy.types.Operator):
    """Type into the search field; the matches follow while you type."""

    bl_idname = "shape_google.gallery_search"
    bl_label = "Search in Gallery"
    bl_description = "Show only matches with a text in their name, tags, catalog or path"

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Write at the end of what is there."""
        text = session_of(context).text
        self._before = text
        state.current().gallery.view.typed = TypedText(text, len(text))
        context.window_manager.modal_handler_add(self)
        context.workspace.status_text_set(tr("Enter: keep  ·  Esc: as before  ·  Ctrl V: paste"))
        context.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        """Take letters and keys."""
        typed = state.current().gallery.view.typed
        if typed is None:  # the results were cleared meanwhile
            return self._end(context)
        if event.type in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE") or event.type.startswith("TIMER"):
            return {"PASS_THROUGH"}
        if event.type in ("RET", "NUMPAD_ENTER", "TAB"):
            return self._end(context) if event.value == "PRESS" else {"RUNNING_MODAL"}
        if event.type == "ESC":
            if event.value == "PRESS":
                self._write(context, TypedText(self._before, len(self._before)))
                return self._end(context)
            return {"RUNNING_MODAL"}
        if event.type.endswith("MOUSE"):
            if "WHEEL" in event.type or event.value != "PRESS":
                return {"PASS_THROUGH"}
            self._end(context)
            return {"FINISHED", "PASS_THROUGH"}
        if event.value == "PRESS":
            self._press(context, event, typed)
        return {"RUNNING_MODAL"}

    def _press(self, context: Any, event: Any, typed: TypedText) -> None:
        command = event.ctrl or event.oskey
        if command and event.type == "V":
            new: TypedText | None = typed.with_input(context.window_manager.clipboard)
        elif command and event.type in ("A", "X"):
            # All of it is marked in effect: what follows replaces it.
            if event.type == "X":
                context.window_manager.clipboard = typed.text
            new = TypedText()
        elif command and event.type == "C":
            context.window_manager.clipboard = typed.text
            return
        else:
            new = typed.with_key(event.type, word=command)
            if new is None and event.unicode and not command:
                new = typed.with_input(event.unicode)
        if new is not None:
            self._write(context, new)

    def _write(self, context: Any, typed: TypedText) -> None:
        session, view = session_of(context), state.current().gallery.view
        view.typed = typed
        if session.text != typed.text:
            session.text = typed.text  # which searches again in a moment
            view.scroll = 0.0
        redraw(context)

    def _end(self, context: Any) -> set[str]:
        self.cancel(context)
        return {"FINISHED"}

    def cancel(self, context: Any) -> None:
        """Stop typing. Blender calls it too when it opens a file or ends."""
        if state.is_registered():
            state.current().gallery.view.typed = None
            redraw(context)
        context.workspace.status_text_set(None)


register, _unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_OT_gallery_search,))


def unregister() -> None:
    """Unregister the operator, which Blender ends without telling it."""
    if state.current().gallery.view.typed is not None:
        for window in bpy.context.window_manager.windows:
            window.workspace.status_text_set(None)
    _unregister()
