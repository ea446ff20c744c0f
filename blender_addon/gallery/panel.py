# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery in the panel Search: the chosen match, and the pictures of all.

All rows are always there, with the same heights: nothing moves under the pointer.
"""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

from ..transfer.panel import draw_transfer
from ..translation import counted, tr
from . import pictures
from .labels import below_picture, details, title
from .on_match import shown_lines

__all__ = ["BUTTONS", "draw_gallery", "draw_match", "draw_versions"]

# Width of a picture in units of the interface, and of a column of the gallery in pixels.
PICTURE_SCALE = 4.6
COLUMN_WIDTH = 105
# More rows would push the following panels out of sight; the other matches are on further pages.
GALLERY_ROWS = 3
# All that can be done with a match; what is not possible with the chosen one is disabled.
BUTTONS = (
    ("select", "RESTRICT_SELECT_OFF"),
    ("append", "APPEND_BLEND"),
    ("link", "LINK_BLEND"),
    ("open", "FILE_BLEND"),
    ("mark", "COLOR"),
    ("compare", "SPLIT_VERTICAL"),
)


def draw_match(layout: Any, session: Any, match: Any | None) -> None:
    """Draw the chosen match with its buttons, in a place and size that do not depend on it.

    Parameters
    ----------
    layout : bpy.types.UILayout
    session : SHAPEGOOGLE_PG_session
    match : SHAPEGOOGLE_PG_match or None
        Without one, all is there but disabled.
    """
    box = layout.box()
    column = box.column(align=True)
    column.enabled = match is not None
    column.label(text=_title(match), icon="OUTLINER_OB_MESH", translate=False)
    lines = column.column(align=True)
    lines.scale_y = 0.8
    for line in _lines(match):
        lines.label(text=line, translate=False)
    grid = box.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
    for name, icon in BUTTONS:
        grid.operator(f"shape_google.{name}_match", icon=icon)
    draw_transfer(grid.row(align=True))
    row = grid.row(align=True)
    row.operator("shape_google.replace_with_match", text="Replace", icon="UV_SYNC_SELECT")
    row.menu("SHAPEGOOGLE_MT_decide", text="", icon="DOWNARROW_HLT")
    marks = [
        example.unlike
        for example in session.examples
        if match is not None and (example.library, example.shape_id) == (session.library, match.shape_id)
    ]
    row = box.row(align=True)
    for unlike, text, icon in ((False, tr("More Like This"), "ADD"), (True, tr("Not Like This"), "REMOVE")):
        button = row.operator("shape_google.mark_example", text=text, icon=icon, depress=unlike in marks)
        button.unlike = unlike
    draw_versions(box, session, match)


def draw_versions(layout: Any, session: Any, match: Any | None) -> None:
    """Draw the button that shows the versions of a match; without any it says so, and is disabled.

    Parameters
    ----------
    layout : bpy.types.UILayout
    session : SHAPEGOOGLE_PG_session
    match : SHAPEGOOGLE_PG_match or None
    """
    row = layout.row()
    row.enabled = session.opened >= 0 or (match is not None and match.version_count > 0)
    row.operator(
        "shape_google.show_versions", text=_versions_text(session, match), icon="DUPLICATE"
    ).index = -1


def _versions_text(session: Any, match: Any | None) -> str:
    """Say what the button does: show the versions of a match, or all shapes again."""
    if session.opened >= 0:
        return tr("Show All Shapes")
    count = 0 if match is None else match.version_count
    if not count:
        return tr("No Other Versions")
    return counted("Show {count:,} Version", "Show {count:,} Versions", count + 1)


def _title(match: Any | None) -> str:
    return tr("No match chosen") if match is None else title(match)


def _lines(match: Any | None) -> list[str]:
    """Where a match is, and what it is; as many lines for each. Blender shortens those that are too long."""
    if match is None:
        return ["", "", ""]
    # The whole path is in the tooltip of the picture.
    where = tr("This scene") if match.in_scene else PurePath(match.source).name or tr("Added without a file")
    if match.since:
        where = f"{tr(match.since)}: {where}"
    return [where, *details(match)]


def draw_gallery(layout: Any, session: Any, context: Any) -> None:
    """Draw a page of pictures with the texts below them, and above it the buttons that turn the pages.

    Parameters
    ----------
    layout : bpy.types.UILayout
    session : SHAPEGOOGLE_PG_session
    context : bpy.types.Context
    """
    lines, active = shown_lines(session)
    shown = list(enumerate(lines))
    scale = context.preferences.system.ui_scale
    columns = max(1, int(context.region.width / (COLUMN_WIDTH * scale)))
    size = columns * GALLERY_ROWS
    pages = max(1, -(-len(shown) // size))
    # The width of the sidebar may leave fewer pages than there were.
    page = min(session.page, pages - 1)
    row = layout.row(align=True)
    _draw_turn(row, page - 1, pages, "TRIA_LEFT")
    middle = row.row()
    middle.alignment = "CENTER"
    last = min((page + 1) * size, len(shown))
    if not shown:
        text = tr("No matches")
    else:
        template = (
            tr("{first} to {last} of {count} versions")
            if session.opened >= 0
            else tr("{first} to {last} of {count}")
        )
        text = template.format(first=page * size + 1, last=last, count=len(shown))
    middle.label(text=text, translate=False)
    _draw_turn(row, page + 1, pages, "TRIA_RIGHT")
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True, even_rows=True, align=True)
    cells: list[tuple[int, Any] | None] = [*shown[page * size : (page + 1) * size]]
    # The last page and no page at all are as high as any other.
    for cell in cells + [None] * (size - len(cells)):
        column = grid.box().column(align=True)
        if cell is None:
            column.template_icon(icon_value=0, scale=PICTURE_SCALE)
            column.label(text="")
            column.label(text="")
            continue
        index, match = cell
        column.template_icon(icon_value=pictures.icon_of(match.shape_id), scale=PICTURE_SCALE)
        row = column.row(align=True)
        row.operator(
            "shape_google.choose_match", text=title(match), translate=False, depress=index == active
        ).index = index
        if match.version_count and session.opened < 0:
            count = row.row(align=True)
            count.scale_x = 0.6
            count.operator("shape_google.show_versions", text=f"+{match.version_count}").index = index
        column.label(text=below_picture(match), translate=False)


def _draw_turn(layout: Any, page: int, pages: int, icon: str) -> None:
    row = layout.row()
    row.enabled = 0 <= page < pages
    row.operator("shape_google.turn_page", text="", icon=icon).page = page
