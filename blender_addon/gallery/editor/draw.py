# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the gallery: the search field, the pictures that can be seen, and a line about one of them."""

from __future__ import annotations

from typing import Any

import bpy

from ... import state
from ...state import session_of
from ...translation import counted, tr
from .. import labels
from ..on_match import shown_lines
from . import area, textures
from .grid import Grid
from .layout import Bars, Box
from .painting import Painter

__all__ = ["badges_of", "register", "unregister"]

# New pictures in one redraw; the others follow in the next ones, so that scrolling never stops the window.
_AT_ONCE = 16


def badges_of(match: Any) -> list[str]:
    """Return short texts for the top right corner of a picture.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    badges : list of str
    """
    return [f"+{match.version_count}"] if match.version_count else []


def _draw() -> None:
    context = bpy.context
    if not state.is_registered() or not area.is_gallery(context.area):
        return
    painter = Painter(context)
    painter.box(Box(0, 0, context.region.width, context.region.height), painter.theme.background)
    view = state.current().gallery.view
    if view.comparison is not None:
        from ..compare.draw import draw_comparison

        draw_comparison(context, painter, view.comparison)
        return
    bars = area.bars_in(context)
    indices = area.shown_indices(context)
    grid = area.grid_in(context, bars.content, len(indices))
    view.scroll = grid.clamped(view.scroll)
    missing = _draw_cells(context, painter, grid, indices)
    _draw_bars(context, painter, bars, grid, len(indices))
    if not indices:
        painter.text(bars.content.shrunk(8 * painter.scale), _nothing(context), painter.theme.faint, "CENTER")
    if missing:
        context.area.tag_redraw()


def _nothing(context: Any) -> str:
    session = session_of(context)
    if session.matches:
        return tr("No match has this text")
    return str(session.answer) or tr("Select an object and click Find Similar")


def _draw_cells(context: Any, painter: Painter, grid: Grid, indices: list[int]) -> bool:
    """Draw those that can be seen; whether pictures are missing yet."""
    view, theme, session = state.current().gallery.view, painter.theme, session_of(context)
    lines, active = shown_lines(session)
    made, missing = 0, False
    visible = grid.visible(view.scroll)
    for position in visible:
        index = indices[position]
        match, cell = lines[index], grid.cell(position, view.scroll)
        is_chosen, is_hovered = index == active, index == view.hovered
        painter.box(cell, theme.chosen if is_chosen else theme.cell)
        if is_hovered and not is_chosen:
            painter.frame(cell, theme.chosen, max(1, round(painter.scale)))
        is_made = textures.is_made(match.shape_id)
        texture = textures.texture_of(match.shape_id, make=made < _AT_ONCE)
        made += not is_made
        missing |= not is_made and made > _AT_ONCE
        picture = grid.picture_in(cell)
        if texture is not None:
            painter.image(picture, texture)
        else:
            painter.text(
                picture, tr("No picture") if textures.is_made(match.shape_id) else "…", theme.faint, "CENTER"
            )
        color = theme.chosen_text if is_chosen else theme.text
        first, second = grid.lines_in(cell)
        painter.text(first, labels.title(match), color, "CENTER")
        painter.text(second, labels.below_picture(match), (*color[:3], 0.8), "CENTER")
        if session.opened < 0:
            _draw_badges(painter, grid.badge_in(cell), badges_of(match))
    textures.drop_oldest(len(visible))
    return missing


def _draw_badges(painter: Painter, first: Box, badges: list[str]) -> None:
    """Write them one below the other."""
    box = first
    for badge in badges:
        left = min(box.left, box.right - painter.width_of(badge) - 8 * painter.scale)
        box = Box(left, box.bottom, box.right, box.top)
        painter.box(box, painter.theme.button)
        painter.text(box, badge, painter.theme.text, "CENTER")
        step = first.height + 2 * painter.scale
        box = Box(first.left, box.bottom - step, first.right, box.top - step)


def _draw_bars(context: Any, painter: Painter, bars: Bars, grid: Grid, count: int) -> None:
    view, theme, session = state.current().gallery.view, painter.theme, session_of(context)
    width, height = context.region.width, context.region.height
    # Cells that are scrolled out lie under the bars.
    painter.box(Box(0, bars.content.top, width, height), theme.background)
    painter.box(Box(0, 0, width, bars.content.bottom), theme.background)
    handle = grid.handle(view.scroll)
    if handle is not None:
        painter.box(handle, (*theme.text[:3], 0.35))
    painter.box(bars.search, theme.field)
    field = bars.search.shrunk(4 * painter.scale)
    if view.typed is not None:
        _draw_typed(painter, field, view.typed)
        painter.frame(bars.search, theme.chosen, max(1, round(painter.scale)))
    elif session.text:
        painter.text(
            Box(field.left, field.bottom, bars.clear.left, field.top), session.text, theme.field_text
        )
    else:
        painter.text(field, tr("Search names, tags and paths"), (*theme.field_text[:3], 0.5))
    if session.text:
        painter.text(bars.clear, "×", theme.field_text, "CENTER")
    for box, sign in ((bars.smaller, "−"), (bars.larger, "+"), (bars.close, "×")):
        painter.box(box, theme.button)
        painter.text(box, sign, theme.text, "CENTER")
    if session.opened >= 0:
        painter.box(bars.count, theme.button)
        painter.text(bars.count, tr("Show All Shapes"), theme.text, "CENTER")
    elif session.matches:
        painter.text(bars.count, counted("{count:,} match", "{count:,} matches", count), theme.faint)
    painter.text(bars.status.shrunk(4 * painter.scale), _status(session, view.hovered), theme.faint)


def _draw_typed(painter: Painter, field: Box, typed: Any) -> None:
    before = typed.text[: typed.caret]
    # The end that is written at is always seen.
    start = 0
    while start < len(before) and painter.width_of(before[start:]) > field.width - 2 * painter.scale:
        start += 1
    painter.text(field, typed.text[start:], painter.theme.field_text)
    x = field.left + painter.width_of(before[start:])
    painter.box(Box(x, field.bottom, x + max(1, round(painter.scale)), field.top), painter.theme.field_text)


def _status(session: Any, hovered: int) -> str:
    lines, active = shown_lines(session)
    index = hovered if 0 <= hovered < len(lines) else active
    if not 0 <= index < len(lines):
        return ""
    return labels.one_line(lines[index])


class _Handler:
    """Blender's handle of the function that draws."""

    handle: object = None


def register() -> None:
    """Draw from now on in every gallery; without a window there is nothing to draw into."""
    if not bpy.app.background:
        _Handler.handle = bpy.types.SpaceNodeEditor.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL")


def unregister() -> None:
    """Draw no more."""
    if _Handler.handle is not None:
        bpy.types.SpaceNodeEditor.draw_handler_remove(_Handler.handle, "WINDOW")
        _Handler.handle = None
    textures.clear()
