# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Duplicates: groups of the same and of similar shapes, to select and to link."""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

import bpy

from ..wrapped_text import wrapped
from .properties import KINDS

__all__ = ["register", "unregister"]

# More lines than these would push the rest of the sidebar out of sight.
MOST_MEMBERS = 12


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
        split.label(text=item.name, icon=KINDS[item.kind][1])
        numbers = split.row()
        numbers.alignment = "RIGHT"
        numbers.label(text=f"{item.meshes} ×")


class SHAPEGOOGLE_PT_duplicates(bpy.types.Panel):
    """Find the same and similar shapes, and let identical ones share one mesh."""

    bl_label = "Duplicates"
    bl_category = "Shape Google"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_order = 40
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        shown = context.window_manager.shape_google_duplicates
        layout.row().prop(shown, "scope", expand=True)
        column = layout.column()
        if shown.scope == "SCENE":
            column.prop(shown, "similar")
        row = column.row()
        row.active = shown.similar or shown.scope == "LIBRARY"
        row.prop(shown, "min_similarity", slider=True)
        if shown.running:
            row = layout.row(align=True)
            row.scale_y = 1.3
            row.progress(factor=shown.progress, text=shown.status)
            row.operator("shape_google.cancel_duplicates", text="", icon="X")
        else:
            row = layout.row()
            row.scale_y = 1.3
            row.operator("shape_google.find_duplicates", icon="VIEWZOOM")
            if shown.status:
                wrapped(layout, shown.status, context)
        if not len(shown.groups):
            return
        layout.template_list("SHAPEGOOGLE_UL_duplicates", "", shown, "groups", shown, "index", rows=4)
        row = layout.row(align=True)
        row.operator("shape_google.select_duplicates", text="Select", icon="RESTRICT_SELECT_OFF")
        if shown.found_in == "SCENE":
            row.operator("shape_google.link_duplicates", icon="LINKED")
        if 0 <= shown.index < len(shown.groups):
            group = shown.groups[shown.index]
            column = layout.column(align=True)
            column.label(
                text=f"{KINDS[group.kind][0]}: {group.meshes} × {group.name}", icon=KINDS[group.kind][1]
            )
            saving = "Copies take" if group.kind == "COPIES" else "One instead of all saves"
            if group.linkable:
                saving = "Linking saves"
            column.label(text=f"{saving} {group.saving}")
            self._draw_members(layout, group)

    def _draw_members(self, layout: Any, group: Any) -> None:
        column = layout.column(align=True)
        column.scale_y = 0.8
        for member in group.members[:MOST_MEMBERS]:
            details = []
            if group.kind == "SIMILAR":
                details.append(f"{member.similarity:.3f}")
            if abs(member.scale - 1) > 1e-4:
                details.append(f"×{member.scale:.4g}")
            if member.note:
                details.append(f"other {member.note}")
            if member.source:
                # The name of a file with one shape is that of the shape: show its folder instead.
                parts = PurePath(member.source).parts[-2:]
                details.append(parts[0] if parts[-1] == member.name else parts[-1])
            row = column.row()
            row.label(text=member.name, icon="OBJECT_DATA")
            if details:
                row.label(text=", ".join(details))
        more = len(group.members) - MOST_MEMBERS
        if more > 0:
            column.label(text=f"and {more} more")


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_UL_duplicates, SHAPEGOOGLE_PT_duplicates)
)
