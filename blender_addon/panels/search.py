# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Search: ask with what is selected, look at the matches, use them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from .. import assets, jobs
from ..properties import session_of, shown_matches
from .text import wrapped

__all__ = ["register", "unregister"]

# Pictures are so many units of the interface wide; a column of the gallery needs a little more.
PICTURE_SCALE = 4.6
COLUMN_PIXELS = 105


class SHAPEGOOGLE_PT_search(bpy.types.Panel):
    """Find the selected shape again."""

    bl_label = "Search"
    bl_category = "Shape Google"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_order = 20

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        session = session_of(context)
        jobs.warm_up_soon()
        row = layout.row(align=True)
        row.scale_y = 1.3
        if session.searching:
            row.label(text=session.answer, icon="SORTTIME")
            row.operator("shape_google.cancel_search", text="", icon="CANCEL")
        else:
            row.operator("shape_google.find_similar", icon="VIEWZOOM")
        if session.answer and not session.searching:
            wrapped(layout, session.answer, context)
        if not session.matches:
            return
        shown = shown_matches(session)
        _draw_gallery(layout, session, shown, context)
        if len(shown) < len(session.matches):
            layout.label(text=f"{len(session.matches) - len(shown)} hidden by the filters", icon="FILTER")
        if any(index == session.active_match for index, _ in shown):
            _draw_match(layout, session.matches[session.active_match], context)


def _draw_gallery(layout: Any, session: Any, shown: list[tuple[int, Any]], context: Any) -> None:
    scale = context.preferences.system.ui_scale
    columns = max(1, int(context.region.width / (COLUMN_PIXELS * scale)))
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True, even_rows=True, align=True)
    for index, match in shown:
        box = grid.box()
        column = box.column(align=True)
        icon = assets.picture_icon(match.shape_id)
        if icon:
            column.template_icon(icon_value=icon, scale=PICTURE_SCALE)
        else:
            column.label(text="No picture")
        column.operator(
            "shape_google.choose_match",
            text=match.object_name or match.name,
            depress=index == session.active_match,
        ).index = index
        column.label(text=f"{similarity_text(match)}  {match.kind}")


def similarity_text(match: Any) -> str:
    """Return a similarity so that only the very same shape is said to be 1."""
    rounded = f"{match.similarity:.2f}"
    return "> 0.99" if rounded == "1.00" and match.distance > 0 else rounded


def _draw_match(layout: Any, match: Any, context: Any) -> None:
    box = layout.box()
    box.label(text=match.object_name or match.name, icon="OUTLINER_OB_MESH")
    where = "This scene" if match.in_scene else match.source or "Added without a file"
    wrapped(box, where if match.in_scene else str(Path(where)), context)
    column = box.column(align=True)
    column.scale_y = 0.85
    column.label(text=f"{match.kind}, similarity {similarity_text(match)}")
    column.label(text=f"{match.vertex_count:,} vertices, size ×{match.size:.3g}")
    grid = box.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    if match.in_scene:
        grid.operator("shape_google.select_match", icon="RESTRICT_SELECT_OFF")
    else:
        grid.operator("shape_google.append_match", icon="APPEND_BLEND")
        grid.operator("shape_google.link_match", icon="LINK_BLEND")
        grid.operator("shape_google.open_match", icon="FILE_BLEND")
    grid.operator("shape_google.mark_match", icon="COLOR")


class SHAPEGOOGLE_PT_filters(bpy.types.Panel):
    """Which matches are shown."""

    bl_label = "Filters"
    bl_category = "Shape Google"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_parent_id = "SHAPEGOOGLE_PT_search"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        session = session_of(context)
        layout.prop(session, "top")
        layout.prop(session, "least_similarity", slider=True)
        layout.prop(session, "source")
        layout.prop(session, "text", icon="VIEWZOOM")
        row = layout.row(heading="Same Size")
        row.prop(session, "use_size", text="")
        sub = row.row()
        sub.enabled = session.use_size
        sub.prop(session, "size_tolerance", text="±")
        layout.prop(session, "collapse")


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PT_search, SHAPEGOOGLE_PT_filters))
