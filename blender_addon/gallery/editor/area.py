# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery as an editor of its own: its entry in the menu of editors, opening and closing it.

Blender has no editors made by add-ons, except that each kind of node tree is one. A tree of this kind is
never made; the editor without one is an empty area with a sidebar, which the gallery draws into.
"""

from __future__ import annotations

from typing import Any

import bpy

from ... import jobs, state
from ...state import session_of
from ...translation import tr
from ..on_match import shown_lines
from .filtering import with_text
from .grid import Grid
from .layout import Bars, Box, arrange, unobstructed

__all__ = [
    "EDITOR",
    "areas",
    "bars_in",
    "grid_in",
    "is_gallery",
    "open_beside",
    "redraw",
    "register",
    "shown_indices",
    "unregister",
]

EDITOR = jobs.GALLERY
# Wider 3D views are divided into left and right, others into top and bottom.
_WIDE = 1.2
# Below a half the new area is at the left or below, so that the sidebar of the 3D view stays where it is.
_SHARE = 0.49
# Seconds until an area that is closed is gone.
_UNTIL_CLOSED = 0.1


class SHAPEGOOGLE_NT_gallery(bpy.types.NodeTree):
    """Matches of the last search as large pictures."""

    bl_idname = EDITOR
    bl_label = "Shape Gallery"
    bl_icon = "ASSET_MANAGER"


class SHAPEGOOGLE_OT_open_gallery(bpy.types.Operator):
    """Open the gallery beside the 3D view, or close it."""

    bl_idname = "shape_google.open_gallery"
    bl_label = "Open Gallery"
    bl_description = (
        "Show the matches as large pictures in an area of their own: click to choose one, double-click to "
        "append it, drag it to where it should stand. Click again to close the area"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is an area to divide."""
        if context.window is None:
            cls.poll_message_set(tr("The gallery needs a window"))
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        """Divide the 3D view, or close what was opened."""
        there = [area for area in context.window.screen.areas if is_gallery(area)]
        if there:
            close(context.window, there[0])
            return {"FINISHED"}
        if open_beside(context) is None:
            self.report(
                {"ERROR"},
                tr(
                    "There is no 3D view with room for the gallery; choose Shape Gallery in the editor menu "
                    "of an area"
                ),
            )
            return {"CANCELLED"}
        return {"FINISHED"}


def is_gallery(area: Any) -> bool:
    """Whether an area shows the gallery; cheap."""
    return area is not None and area.type == "NODE_EDITOR" and area.spaces.active.tree_type == EDITOR


def areas(context: Any) -> list[tuple[Any, Any]]:
    """Return the windows and areas that show the gallery.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    areas : list of (bpy.types.Window, bpy.types.Area)
    """
    windows = context.window_manager.windows
    return [(window, area) for window in windows for area in window.screen.areas if is_gallery(area)]


def redraw(context: Any) -> None:
    """Have the galleries drawn again."""
    for _, area in areas(context):
        area.tag_redraw()


def open_beside(context: Any) -> Any | None:
    """Show the gallery in the window; if it is not shown yet, beside the 3D view.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    area : bpy.types.Area or None
        None if there is no 3D view with room for it.
    """
    screen = context.window.screen
    known = [area for area in screen.areas if is_gallery(area)]
    if known:
        return known[0]
    views = [area for area in screen.areas if area.type == "VIEW_3D"]
    if not views:
        return None
    own = context.area if context.area in views else None
    view = own or max(views, key=lambda area: area.width * area.height)
    region = next(region for region in view.regions if region.type == "WINDOW")
    before = set(screen.areas)
    direction = "VERTICAL" if view.width > _WIDE * view.height else "HORIZONTAL"
    with context.temp_override(window=context.window, area=view, region=region):
        try:
            bpy.ops.screen.area_split(direction=direction, factor=_SHARE)
        except RuntimeError:  # too small
            return None
    new = [area for area in screen.areas if area not in before]
    if not new:
        return None
    chosen = new[0]
    chosen.ui_type = EDITOR
    space = chosen.spaces.active
    space.show_region_header = space.show_region_toolbar = space.show_region_ui = False
    return chosen


def close(window: Any, area: Any) -> None:
    """Close an area, if another one can take its place."""
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        if window.screen.show_fullscreen:
            bpy.ops.screen.back_to_previous()
        elif bpy.ops.screen.area_close.poll():
            bpy.ops.screen.area_close()
    # Blender counts the area among those of the screen until it has drawn the window again.
    bpy.app.timers.register(_show_closed, first_interval=_UNTIL_CLOSED)


def _show_closed() -> None:
    """Have the sidebars show that the gallery is closed."""
    if state.is_registered():
        jobs.redraw()


def shown_indices(context: Any) -> list[int]:
    """Return the positions of the matches that the gallery shows.

    While the library has not answered yet, those of its last answer that have the text of the search field.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    indices : list of int
    """
    session, search = session_of(context), state.current().search
    lines, _ = shown_lines(session)
    pending = search.refine_at > 0 or (search.waiting is not None and not session.searching)
    return with_text(lines, session.text) if pending else list(range(len(lines)))


def bars_in(context: Any) -> Bars:
    """Return the parts of the gallery in the region of the context."""
    overlapping = context.preferences.system.use_region_overlap
    area, region = context.area, context.region
    sides = [
        (other.alignment, other.width if other.alignment in ("LEFT", "RIGHT") else other.height)
        for other in area.regions
        if overlapping and other.type in ("TOOLS", "UI") and _covers(region, other)
    ]
    box = unobstructed(region.width, region.height, sides)
    return arrange(box, context.preferences.system.ui_scale)


def _covers(region: Any, other: Any) -> bool:
    """Whether a region lies on another one; those beside it do not."""
    return bool(
        other.x < region.x + region.width
        and other.x + other.width > region.x
        and other.y < region.y + region.height
        and other.y + other.height > region.y
    )


def grid_in(context: Any, content: Box, count: int) -> Grid:
    """Return the cells of the gallery in the region of the context."""
    size, scale = session_of(context).picture_size, context.preferences.system.ui_scale
    return Grid.of(content, count, size, scale)


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_NT_gallery, SHAPEGOOGLE_OT_open_gallery)
)
