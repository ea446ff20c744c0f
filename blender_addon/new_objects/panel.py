# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel New Objects: objects that the library has already, or nearly, and what to do about them.

All rows are always there, with the same heights: nothing moves under the pointer.
"""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

import bpy

from ..gallery.labels import details, title
from ..library.present import follow
from ..progress_bar import progress_bar
from ..sidebar import SidebarPanel
from ..state import session_of
from ..translation import tr
from ..wrapped_text import fixed_text
from .use import active_line

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_UL_new_objects(bpy.types.UIList):
    """Objects that the library has already, or nearly."""

    def draw_item(
        self,
        _context: Any,
        layout: Any,
        _data: Any,
        item: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        """One line for an object."""
        row = layout.split(factor=0.58)
        name = item.name if item.object_count == 1 else f"{item.object_count} × {item.name}"
        row.label(text=name, icon="OUTLINER_OB_MESH", translate=False)
        row.label(text=item.match.kind, translate=False)


class SHAPEGOOGLE_PT_new_objects(SidebarPanel, bpy.types.Panel):
    """Find out whether what was imported or appended is in the library already."""

    bl_label = "New Objects"
    bl_order = 42
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        follow(context)
        session = session_of(context)
        layout.row().prop(session, "check_which", expand=True)
        layout.prop(session, "check_similarity", slider=True)
        row = layout.row(align=True)
        row.scale_y = 1.3
        if session.checking:
            progress_bar(row, session, "check_percent")
        else:
            row.operator("shape_google.check_new_objects", icon="VIEWZOOM")
        row.operator("shape_google.cancel_check", text="", icon="X")
        fixed_text(layout, session.check_status, context)
        layout.template_list(
            "SHAPEGOOGLE_UL_new_objects",
            "",
            session,
            "new_objects",
            session,
            "active_new_object",
            rows=4,
            maxrows=4,
        )
        line = active_line(context)
        column = layout.column(align=True)
        if line is None:
            texts = [tr("No object chosen"), "", "", ""]
        else:
            match = line.match
            where = PurePath(match.source).name or tr("Added without a file")
            texts = [title(match), where, *details(match)]
        for text in texts:
            column.label(text=text, translate=False)
        row = layout.row(align=True)
        row.operator("shape_google.select_new_object", icon="RESTRICT_SELECT_OFF")
        row.operator("shape_google.replace_new_object", icon="UV_SYNC_SELECT")
        row = layout.row(align=True)
        row.operator("shape_google.keep_new_object", text="Dismiss", icon="CHECKMARK").remember = False
        both = row.operator("shape_google.keep_new_object", text="Keep Both", icon="DUPLICATE")
        both.remember = True


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_UL_new_objects, SHAPEGOOGLE_PT_new_objects)
)
