# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Decisions: what was decided about shapes of the library, to be taken back.

All rows are always there, with the same heights: nothing moves under the pointer.
"""

from __future__ import annotations

from typing import Any

import bpy

from ..library.present import follow
from ..sidebar import SidebarPanel
from ..state import session_of
from ..wrapped_text import fixed_text

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_UL_decisions(bpy.types.UIList):
    """Decisions, the latest first."""

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
        """One line for a decision."""
        row = layout.row(align=True)
        row.prop(item, "chosen", text="")
        row.label(text=item.name, icon=item.icon, translate=False)


class SHAPEGOOGLE_PT_decisions(SidebarPanel, bpy.types.Panel):
    """See what was decided about shapes of the library, and take it back."""

    bl_label = "Decisions"
    bl_order = 45
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, context: Any) -> None:
        """Show their number at the right of the title."""
        count = len(session_of(context).decisions)
        if count:
            self.layout.label(text=f"{count:,}")

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        follow(context)
        session = session_of(context)
        layout.template_list(
            "SHAPEGOOGLE_UL_decisions",
            "",
            session,
            "decisions",
            session,
            "active_decision",
            rows=5,
            maxrows=5,
        )
        count = len(session.decisions)
        line = session.decisions[session.active_decision] if 0 <= session.active_decision < count else None
        fixed_text(layout, "" if line is None else line.name, context)
        column = layout.column()
        if line is None:
            column.label(text="Nothing was decided yet")
        else:
            column.label(
                text=", ".join(part for part in (line.author, line.time) if part),
                icon="USER",
                translate=False,
            )
        layout.operator("shape_google.undo_decisions", icon="LOOP_BACK").index = -1
        fixed_text(layout, session.decided, context)


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_UL_decisions, SHAPEGOOGLE_PT_decisions)
)
