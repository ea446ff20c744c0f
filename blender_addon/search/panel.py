# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Search: ask with what is selected, look at the matches, use them."""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

import bpy

from .. import connections, jobs, scene
from ..preferences import preferences
from ..session import examples_of, session_of, shown_matches
from ..transfer import operators as transfer
from ..wrapped_text import wrapped

__all__ = ["register", "unregister"]

# Pictures are so many units of the interface wide; a column of the gallery needs a little more, in pixels.
PICTURE_SCALE = 4.6
COLUMN_WIDTH = 105
# More rows would push what follows out of sight; the other matches are on further pages.
GALLERY_ROWS = 3


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
        if context.mode == "OBJECT" and len(scene.shape_objects(context.selected_objects)) > 1:
            layout.row(heading="Several").prop(session, "several", expand=True)
        _draw_examples(layout, examples_of(session, preferences(context).library_path()))
        _draw_filters(layout, session)
        if session.answer and not session.searching:
            wrapped(layout, session.answer, context)
        if not session.matches:
            return
        shown = shown_matches(session)
        if any(index == session.active_match for index, _ in shown):
            _draw_match(layout, session, session.matches[session.active_match])
        _draw_gallery(layout, session, shown, context)
        hidden = len(session.matches) - len(shown)
        if hidden:
            layout.label(text=f"{hidden} hidden by the filters", icon="FILTER")


def warm_up(context: Any) -> None:
    """Get ready: whoever looks at a panel is about to ask the library something, or to paint."""
    jobs.warm_up_soon(preferences(context).library_path(), _show_count)


def _show_count(shapes: int) -> None:
    session_of(bpy.context).shape_count = shapes


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


def _draw_match(layout: Any, session: Any, match: Any) -> None:
    box = layout.box()
    column = box.column(align=True)
    column.label(text=match.object_name or match.name, icon="OUTLINER_OB_MESH")
    # Its whole path is in the tooltip of its picture: here it would push the gallery about.
    where = "This scene" if match.in_scene else PurePath(match.source).name or "Added without a file"
    details = column.column(align=True)
    details.scale_y = 0.8
    details.label(text=where)
    details.label(text=f"{without_size(match.kind)}, similarity {similarity_text(match)}")
    details.label(text=f"{match.vertex_count:,} vertices, size ×{match.size:.3g}")
    grid = box.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    if match.in_scene:
        grid.operator("shape_google.select_match", icon="RESTRICT_SELECT_OFF")
    else:
        grid.operator("shape_google.append_match", icon="APPEND_BLEND")
        grid.operator("shape_google.link_match", icon="LINK_BLEND")
        grid.operator("shape_google.open_match", icon="FILE_BLEND")
    grid.operator("shape_google.mark_match", icon="COLOR")
    row = box.row(align=True)
    waiting = transfer.running()
    if waiting:
        row.label(text=waiting, icon="SORTTIME")
        row.operator("shape_google.cancel_transfer", text="", icon="X")
    else:
        row.operator("shape_google.transfer_match", icon="MOD_DATA_TRANSFER")
    marks = [
        example.unlike
        for example in session.examples
        if (example.library, example.shape_id) == (session.library, match.shape_id)
    ]
    row = box.row(align=True)
    for unlike, text, icon in ((False, "More Like This", "ADD"), (True, "Not Like This", "REMOVE")):
        button = row.operator("shape_google.mark_example", text=text, icon=icon, depress=unlike in marks)
        button.unlike = unlike
    # Only at full width, so not in the box.
    _draw_transfer(layout, session)


def _draw_transfer(layout: Any, session: Any) -> None:
    header, body = layout.panel("SHAPEGOOGLE_transfer", default_closed=True)
    header.label(text="What to Transfer")
    if body is None:
        return
    body.use_property_split = True
    body.use_property_decorate = False
    column = body.column(heading="Carry Over")
    column.prop(session, "transfer_groups")
    column.prop(session, "transfer_colors")
    column.prop(session, "transfer_uvs")
    body.prop(session, "transfer_replace")


def _draw_gallery(layout: Any, session: Any, shown: list[tuple[int, Any]], context: Any) -> None:
    scale = context.preferences.system.ui_scale
    columns = max(1, int(context.region.width / (COLUMN_WIDTH * scale)))
    size = columns * GALLERY_ROWS
    pages = max(1, -(-len(shown) // size))
    # Filters and the width of the sidebar may leave fewer pages than there were.
    page = min(session.page, pages - 1)
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True, even_rows=True, align=True)
    for index, match in shown[page * size : (page + 1) * size]:
        column = grid.box().column(align=True)
        icon = connections.picture_icon(match.shape_id)
        if icon:
            column.template_icon(icon_value=icon, scale=PICTURE_SCALE)
        else:
            column.label(text="No picture")
        column.operator(
            "shape_google.choose_match",
            text=match.object_name or match.name,
            depress=index == session.active_match,
        ).index = index
        column.label(text=f"{similarity_text(match)}  {short_kind(match.kind)}")
    if pages > 1:
        row = layout.row(align=True)
        _draw_turn(row, page - 1, pages, "TRIA_LEFT")
        middle = row.row()
        middle.alignment = "CENTER"
        middle.label(text=f"{page * size + 1} to {min((page + 1) * size, len(shown))} of {len(shown)}")
        _draw_turn(row, page + 1, pages, "TRIA_RIGHT")


def _draw_turn(layout: Any, page: int, pages: int, icon: str) -> None:
    row = layout.row()
    row.enabled = 0 <= page < pages
    row.operator("shape_google.turn_page", text="", icon=icon).page = page


def similarity_text(match: Any) -> str:
    """Return a similarity so that only the very same shape is said to be 1."""
    rounded = f"{match.similarity:.2f}"
    return "0.99+" if rounded == "1.00" and match.distance > 0 else rounded


def without_size(kind: str) -> str:
    """Leave out of what kind a match is how large it is, unless that is all: of "Re-posed ×0.9" the size."""
    return kind if kind.startswith("Scaled") else kind.partition(" ×")[0].rstrip(",")


def short_kind(kind: str) -> str:
    """Shorten what kind a match is for a picture's width: "Same mesh, re-posed" to "Re-posed"."""
    short = without_size(kind).rpartition(", ")[2].replace("The query is ", "")
    return short[:1].upper() + short[1:]


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PT_search,))
