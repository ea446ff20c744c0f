# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Search: query with the selection, filter the matches, and look at them.

All rows are always there, with the same heights, also before the first search: nothing moves under the
pointer.
"""

from __future__ import annotations

from typing import Any

import bpy

from ..gallery import panel as gallery
from ..gallery.editor import area
from ..gallery.on_match import active_match
from ..library.address import library_key, library_missing
from ..library.present import follow
from ..scene.selection import query_objects
from ..sidebar import SidebarPanel
from ..state import session_of
from ..transfer.panel import draw_choices
from ..translation import OWN_CONTEXT, tr
from ..wrapped_text import fixed_text
from .properties import examples_of

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_PT_search(SidebarPanel, bpy.types.Panel):
    """Find the selected shape again."""

    bl_label = "Search"
    # Blender's own German for this word means an area to search.
    bl_translation_context = OWN_CONTEXT
    bl_order = 20

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        session = session_of(context)
        follow(context)
        row = layout.row(align=True)
        row.scale_y = 1.3
        row.operator("shape_google.find_similar", icon="VIEWZOOM")
        # A row of its own would push the pictures below the edge of a small screen.
        is_open = any(map(area.is_gallery, context.screen.areas))
        row.operator("shape_google.open_gallery", text="", icon="ASSET_MANAGER", depress=is_open)
        row.operator("shape_google.cancel_search", text="", icon="X")
        fixed_text(layout, session.answer or _first_step(context), context)
        _draw_examples(layout, session, context)
        layout.operator("shape_google.suggest_tags", icon="BOOKMARKS")
        _draw_filters(layout, session)
        gallery.draw_match(layout, session, active_match(context))
        # Before all that is needed less often: on a small screen one row of it fits, with its names.
        gallery.draw_gallery(layout, session, context)
        draw_choices(layout, session)


def _first_step(context: Any) -> str:
    """Say what to do before the first search."""
    return library_missing(context) or tr("Select an object and click Find Similar")


def _draw_examples(layout: Any, session: Any, context: Any) -> None:
    examples = [example for _, example in examples_of(session, library_key(context))]
    unlike = sum(example.unlike for example in examples)
    header, body = layout.panel_prop(session, "show_examples")
    text = tr("Examples: {like} like, {unlike} not like")
    header.label(text=text.format(like=len(examples) - unlike, unlike=unlike), translate=False)
    header.operator("shape_google.clear_examples", text="", icon="TRASH", emboss=False)
    if body is None:
        return
    row = body.row(heading="Several")
    row.enabled = context.mode == "OBJECT" and len(query_objects(context.selected_objects)) > 1
    row.prop(session, "several", expand=True)
    row = body.row()
    row.template_list(
        "SHAPEGOOGLE_UL_examples", "", session, "examples", session, "active_example", rows=3, maxrows=3
    )
    row.column().operator("shape_google.remove_example", text="", icon="REMOVE").index = -1


class SHAPEGOOGLE_UL_examples(bpy.types.UIList):
    """Examples from the present library."""

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
        """Lay an example out."""
        text = (tr("Not like {name}") if item.unlike else tr("Like {name}")).format(name=item.name)
        if item.is_gone:
            text = tr("{example}: no longer indexed").format(example=text)
        icon = "ERROR" if item.is_gone else "REMOVE" if item.unlike else "ADD"
        layout.label(text=text, translate=False, icon=icon)

    def draw_filter(self, _context: Any, _layout: Any) -> None:
        """Leave the filters of lists out: examples of other libraries must stay hidden."""

    def filter_items(self, context: Any, data: Any, _name: str) -> tuple[list[int], list[int]]:
        """Show the examples of the present library."""
        own = {index for index, _ in examples_of(data, library_key(context))}
        return [self.bitflag_filter_item if index in own else 0 for index in range(len(data.examples))], []


def _draw_filters(layout: Any, session: Any) -> None:
    header, body = layout.panel("SHAPEGOOGLE_filters", default_closed=True)
    header.label(text="Filters")
    if body is None:
        return
    body.use_property_split = True
    body.use_property_decorate = False
    body.prop(session, "top")
    body.prop(session, "rank")
    body.prop(session, "least_similarity", slider=True)
    body.prop(session, "source")
    body.prop(session, "text", icon="VIEWZOOM")
    body.prop(session, "shape_type")
    body.prop(session, "tag")
    body.prop(session, "catalog")
    body.prop(session, "evidence")
    row = body.row(align=True)
    row.prop(session, "least_faces")
    row.prop(session, "most_faces", text="")
    row = body.row(heading="Same Size")
    row.prop(session, "use_size", text="")
    sub = row.row()
    sub.enabled = session.use_size
    sub.prop(session, "size_tolerance", text="")
    body.prop(session, "collapse")


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_UL_examples, SHAPEGOOGLE_PT_search))
