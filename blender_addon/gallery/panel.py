# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery in the panel Search: the chosen match, and the pictures of all."""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

from ..transfer.panel import draw_transfer
from . import pictures
from .labels import below_picture, details

__all__ = ["draw_gallery", "draw_match"]

# Width of a picture in units of the interface, and of a column of the gallery in pixels.
PICTURE_SCALE = 4.6
COLUMN_WIDTH = 105
# More rows would push the following panels out of sight; the other matches are on further pages.
GALLERY_ROWS = 3


def draw_match(layout: Any, session: Any, match: Any) -> None:
    """Draw the chosen match with its buttons.

    Parameters
    ----------
    layout : bpy.types.UILayout
    session : SHAPEGOOGLE_PG_session
    match : SHAPEGOOGLE_PG_match
    """
    box = layout.box()
    column = box.column(align=True)
    column.label(text=match.object_name or match.name, icon="OUTLINER_OB_MESH")
    # The whole path is in the tooltip of the picture; here it would move the gallery up and down.
    where = "This scene" if match.in_scene else PurePath(match.source).name or "Added without a file"
    lines = column.column(align=True)
    lines.scale_y = 0.8
    for line in (where, *details(match)):
        lines.label(text=line)
    grid = box.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    if match.in_scene:
        grid.operator("shape_google.select_match", icon="RESTRICT_SELECT_OFF")
    else:
        grid.operator("shape_google.append_match", icon="APPEND_BLEND")
        grid.operator("shape_google.link_match", icon="LINK_BLEND")
        grid.operator("shape_google.open_match", icon="FILE_BLEND")
    grid.operator("shape_google.mark_match", icon="COLOR")
    draw_transfer(box.row(align=True))
    marks = [
        example.unlike
        for example in session.examples
        if (example.library, example.shape_id) == (session.library, match.shape_id)
    ]
    row = box.row(align=True)
    for unlike, text, icon in ((False, "More Like This", "ADD"), (True, "Not Like This", "REMOVE")):
        button = row.operator("shape_google.mark_example", text=text, icon=icon, depress=unlike in marks)
        button.unlike = unlike


def draw_gallery(layout: Any, session: Any, shown: list[tuple[int, Any]], context: Any) -> None:
    """Draw a page of pictures with the texts below them.

    Parameters
    ----------
    layout : bpy.types.UILayout
    session : SHAPEGOOGLE_PG_session
    shown : list of (int, SHAPEGOOGLE_PG_match)
        The matches that pass the filters, each with its index.
    context : bpy.types.Context
    """
    scale = context.preferences.system.ui_scale
    columns = max(1, int(context.region.width / (COLUMN_WIDTH * scale)))
    size = columns * GALLERY_ROWS
    pages = max(1, -(-len(shown) // size))
    # Filters and the width of the sidebar may leave fewer pages than there were.
    page = min(session.page, pages - 1)
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True, even_rows=True, align=True)
    for index, match in shown[page * size : (page + 1) * size]:
        column = grid.box().column(align=True)
        icon = pictures.icon_of(match.shape_id)
        if icon:
            column.template_icon(icon_value=icon, scale=PICTURE_SCALE)
        else:
            column.label(text="No picture")
        column.operator(
            "shape_google.choose_match",
            text=match.object_name or match.name,
            depress=index == session.active_match,
        ).index = index
        column.label(text=below_picture(match))
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
