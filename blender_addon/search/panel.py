# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Search: query with the selection, filter the matches, and look at them."""

from __future__ import annotations

from typing import Any

import bpy

from ..gallery import panel as gallery
from ..gallery.filters import shown_matches
from ..library.warm_up import warm_up
from ..preferences import preferences
from ..scene.selection import shape_objects
from ..state import session_of
from ..transfer.panel import draw_choices
from ..wrapped_text import wrapped
from .properties import examples_of

__all__ = ["register", "unregister"]


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
        warm_up(context)
        row = layout.row(align=True)
        row.scale_y = 1.3
        if session.searching:
            row.label(text=session.answer, icon="SORTTIME")
            row.operator("shape_google.cancel_search", text="", icon="X")
        else:
            row.operator("shape_google.find_similar", icon="VIEWZOOM")
        if context.mode == "OBJECT" and len(shape_objects(context.selected_objects)) > 1:
            layout.row(heading="Several").prop(session, "several", expand=True)
        _draw_examples(layout, examples_of(session, preferences(context).library_path()))
        _draw_filters(layout, session)
        if session.answer and not session.searching:
            wrapped(layout, session.answer, context)
        if not session.matches:
            return
        shown = shown_matches(session)
        if any(index == session.active_match for index, _ in shown):
            gallery.draw_match(layout, session, session.matches[session.active_match])
            # Only at full width, so not in the box.
            draw_choices(layout, session)
        gallery.draw_gallery(layout, session, shown, context)
        hidden = len(session.matches) - len(shown)
        if hidden:
            layout.label(text=f"{hidden} hidden by the filters", icon="FILTER")


def _draw_examples(layout: Any, examples: list[tuple[int, Any]]) -> None:
    if not examples:
        return
    column = layout.box().column(align=True)
    row = column.row()
    row.label(text="Examples from the Library")
    row.operator("shape_google.clear_examples", text="", icon="TRASH", emboss=False)
    for index, example in examples:
        row = column.row()
        kind = "Not like" if example.unlike else "Like"
        row.label(text=f"{kind} {example.name}", icon="REMOVE" if example.unlike else "ADD")
        row.operator("shape_google.remove_example", text="", icon="X", emboss=False).index = index


def _draw_filters(layout: Any, session: Any) -> None:
    header, body = layout.panel("SHAPEGOOGLE_filters", default_closed=True)
    header.label(text="Filters")
    if body is None:
        return
    body.use_property_split = True
    body.use_property_decorate = False
    body.prop(session, "top")
    body.prop(session, "least_similarity", slider=True)
    body.prop(session, "source")
    body.prop(session, "text", icon="VIEWZOOM")
    row = body.row(heading="Same Size")
    row.prop(session, "use_size", text="")
    sub = row.row()
    sub.enabled = session.use_size
    sub.prop(session, "size_tolerance", text="")
    body.prop(session, "collapse")


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PT_search,))
