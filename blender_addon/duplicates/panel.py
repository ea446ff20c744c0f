# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Duplicates: groups of the same and of similar shapes, to select and to link.

All rows are always there, with the same heights: nothing moves under the pointer.
"""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

import bpy

from ..library.present import follow
from ..progress_bar import progress_bar
from ..sidebar import SidebarPanel
from ..translation import tr
from ..wrapped_text import fixed_text
from .properties import KINDS, saving_text

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_UL_duplicates(bpy.types.UIList):
    """Groups of duplicates."""

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
        """One line for a group."""
        row = layout.row(align=True)
        if item.linkable:
            row.prop(item, "chosen", text="")
        else:
            row.label(text="", icon="BLANK1")
        # The sidebar is narrow: the icon tells the kind, and the words are below the list.
        split = row.split(factor=0.8)
        split.label(text=item.name, translate=False, icon=KINDS[item.kind][1])
        numbers = split.row()
        numbers.alignment = "RIGHT"
        numbers.label(text=f"{item.meshes} ×")


class SHAPEGOOGLE_PT_duplicates(SidebarPanel, bpy.types.Panel):
    """Find the same and similar shapes, and let identical ones share one mesh."""

    bl_label = "Duplicates"
    bl_order = 40
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        follow(context)
        shown = context.window_manager.shape_google_duplicates
        layout.row().prop(shown, "scope", expand=True)
        column = layout.column()
        row = column.row()
        row.enabled = shown.scope == "SCENE"
        row.prop(shown, "similar")
        row = column.row()
        row.active = shown.similar or shown.scope == "LIBRARY"
        row.prop(shown, "min_similarity", slider=True)
        row = layout.row(align=True)
        row.scale_y = 1.3
        if shown.running:
            progress_bar(row, shown, "percent")
        else:
            row.operator("shape_google.find_duplicates", icon="VIEWZOOM")
        row.operator("shape_google.cancel_duplicates", text="", icon="X")
        fixed_text(layout, shown.status, context)
        layout.template_list(
            "SHAPEGOOGLE_UL_duplicates", "", shown, "groups", shown, "index", rows=4, maxrows=4
        )
        row = layout.row(align=True)
        row.operator("shape_google.choose_duplicates", text="", icon="CHECKBOX_HLT")
        row.operator("shape_google.select_duplicates", text="Select", icon="RESTRICT_SELECT_OFF")
        row.operator("shape_google.link_duplicates", icon="LINKED")
        row = layout.row(align=True)
        row.operator("shape_google.decide_duplicate", text="Keep Both", icon="DUPLICATE").kind = "KEEP_BOTH"
        master = row.operator("shape_google.decide_duplicate", text="Set as Master", icon="FUND")
        master.kind = "MASTER"
        group = shown.groups[shown.index] if 0 <= shown.index < len(shown.groups) else None
        column = layout.column(align=True)
        if group is None:
            column.label(text="No group chosen")
            column.label(text="")
        else:
            kind, icon = KINDS[group.kind]
            text = f"{tr(kind)}: {group.meshes} × {group.name}"
            column.label(text=text, translate=False, icon=icon)
            column.label(text=_saving(group), translate=False)
        # A list of no group has to have some owner: an empty one takes that of the settings.
        owner = shown if group is None else group
        column = layout.column(align=True)
        column.template_list(
            "SHAPEGOOGLE_UL_duplicate_members",
            "",
            owner,
            "members",
            owner,
            "active_member",
            rows=3,
            maxrows=3,
        )
        # In the list there is no room for a long text.
        chosen = 0 <= owner.active_member < len(owner.members)
        fixed_text(column, _details(group, owner.members[owner.active_member]) if chosen else "", context, 1)


def _saving(group: Any) -> str:
    if group.linkable:
        template = tr("Linking saves {amount}")
    elif group.kind == "COPIES":
        template = tr("Copies take {amount}")
    else:
        template = tr("Keeping one of them saves {amount}")
    return template.format(amount=saving_text(group))


class SHAPEGOOGLE_UL_duplicate_members(bpy.types.UIList):
    """Members of a group of duplicates."""

    def draw_item(
        self,
        _context: Any,
        layout: Any,
        data: Any,
        item: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        """One line for a member."""
        row = layout.row()
        row.label(text=item.title, translate=False, icon="OBJECT_DATA")
        details = _details(data, item)
        if details:
            row.label(text=details, translate=False)


def _details(group: Any, member: Any) -> str:
    """Say what a member differs in from the first one, and where it is."""
    details = []
    if group.kind == "SIMILAR":
        details.append(f"{member.similarity:.3f}")
    if abs(member.scale - 1) > 1e-4:
        details.append(f"×{member.scale:.4g}")
    if member.note:
        details.append(tr("differs in: {data}").format(data=member.note))
    if member.source:
        # The name of a file with one shape is that of the shape: show its folder instead.
        parts = PurePath(member.source).parts[-2:]
        details.append(parts[0] if parts[-1] == member.title else parts[-1])
    return ", ".join(details)


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_UL_duplicates, SHAPEGOOGLE_UL_duplicate_members, SHAPEGOOGLE_PT_duplicates)
)
