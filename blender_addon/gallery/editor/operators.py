# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pointer and the keys do in the gallery."""

from __future__ import annotations

import time
from typing import Any, ClassVar

import bpy
from bpy.props import EnumProperty

from ... import jobs, state
from ...state import session_of
from ...translation import tr
from ..on_match import active_match, shown_lines
from . import area, dragging
from .grid import Grid
from .layout import LARGEST_PICTURE, SMALLEST_PICTURE, Bars

__all__ = ["InGallery", "register", "unregister"]

# Pixels at a scale of 1, for one step of the wheel; and of the size of pictures.
_WHEEL, _ZOOM = 60, 32


class InGallery:
    """Base of operators that work in the gallery only, so that other editors keep their keys."""

    bl_options: ClassVar = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that the pointer is over the pictures."""
        return (
            area.is_gallery(context.area) and context.region is not None and context.region.type == "WINDOW"
        )


def parts(context: Any) -> tuple[Bars, Grid, list[int]]:
    """Return the bars, the cells, and the positions of the matches in them."""
    bars, indices = area.bars_in(context), area.shown_indices(context)
    return bars, area.grid_in(context, bars.content, len(indices)), indices


def match_at(context: Any, x: float, y: float) -> int:
    """Return the position of the match at a place of the region; −1 for none."""
    _, grid, indices = parts(context)
    found = grid.at(x, y, state.current().gallery.view.scroll)
    return -1 if found is None else indices[found]


def choose(index: int) -> None:
    """Choose a match, and draw the sidebars again."""
    bpy.ops.shape_google.choose_match(index=index)
    jobs.redraw()


class SHAPEGOOGLE_OT_gallery_press(InGallery, bpy.types.Operator):
    """Choose a match, append it by a double click, or drag it into a 3D view."""

    bl_idname = "shape_google.gallery_press"
    bl_label = "Use Gallery"
    bl_description = (
        "Choose the match under the pointer, append it by a double click, or drag it to its place"
    )

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Do what is at the pointer."""
        view = state.current().gallery.view
        if view.comparison is not None:
            if area.bars_in(context).close.holds(event.mouse_region_x, event.mouse_region_y):
                view.comparison = None
                context.area.tag_redraw()
            else:
                bpy.ops.shape_google.gallery_turn("INVOKE_DEFAULT")
            return {"FINISHED"}
        x, y = event.mouse_region_x, event.mouse_region_y
        bars, grid, _ = parts(context)
        button = bars.button_at(x, y)
        if button is not None:
            self._press(context, button)
            return {"FINISHED"}
        if grid.handle(view.scroll) is not None and grid.bar.holds(x, y):
            self._start = y, view.scroll
            return self._hold(context, "scroll")
        index = match_at(context, x, y)
        if index < 0:
            return {"FINISHED"}
        choose(index)
        if event.value == "DOUBLE_CLICK":
            # The third of three quick clicks makes another double click with the second.
            again = (
                time.monotonic() - view.used_at < context.preferences.inputs.mouse_double_click_time / 1000
            )
            if not again:
                use(self, context)
            view.used_at = time.monotonic()
            return {"FINISHED"}
        lines, _ = shown_lines(session_of(context))
        if lines[index].version_count and session_of(context).opened < 0:
            cell = grid.cell(grid.at(x, y, view.scroll) or 0, view.scroll)
            if grid.badge_in(cell).holds(x, y):
                bpy.ops.shape_google.show_versions("INVOKE_DEFAULT", index=index)
                return {"FINISHED"}
        self._start, self._shape = (event.mouse_x, event.mouse_y), lines[index].shape_id
        return self._hold(context, "match")

    def _press(self, context: Any, button: str) -> None:
        session = session_of(context)
        if button == "search":
            bpy.ops.shape_google.gallery_search("INVOKE_DEFAULT")
        elif button == "clear":
            if session.text:
                session.text = ""
            else:
                bpy.ops.shape_google.gallery_search("INVOKE_DEFAULT")
        elif button == "close":
            area.close(context.window, context.area)
            return
        elif button == "count" and session.opened >= 0:
            bpy.ops.shape_google.show_versions("INVOKE_DEFAULT", index=-1)
        elif button in ("smaller", "larger"):
            resize(context, -1 if button == "smaller" else 1)
        context.area.tag_redraw()

    def _hold(self, context: Any, what: str) -> set[str]:
        self._what = what
        self._dragged: dragging.Dragged | None = None
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        """Follow the pointer until the button is released."""
        if event.type in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE"):
            self._follow(context, event)
        elif event.type in ("ESC", "RIGHTMOUSE") and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            return self._release(context, event)
        return {"RUNNING_MODAL"}

    def cancel(self, context: Any) -> None:
        """Stop dragging. Blender calls it too when it opens a file or ends."""
        if self._dragged is not None:
            dragging.end(context, self._dragged)
            self._dragged = None

    def _follow(self, context: Any, event: Any) -> None:
        if self._what == "scroll":
            _, grid, _ = parts(context)
            start, scroll = self._start
            state.current().gallery.view.scroll = grid.dragged(scroll, start - event.mouse_region_y)
            context.area.tag_redraw()
            return
        if self._dragged is None:
            limit = context.preferences.inputs.drag_threshold_mouse * context.preferences.system.ui_scale
            x, y = self._start
            if max(abs(event.mouse_x - x), abs(event.mouse_y - y)) < limit:
                return
            self._dragged = dragging.begin(context, self._shape, event.mouse_x, event.mouse_y)
        dragging.move(context, self._dragged, event.mouse_x, event.mouse_y)

    def _release(self, context: Any, event: Any) -> set[str]:
        if self._dragged is None:
            return {"FINISHED"}
        self.cancel(context)
        inside = context.area is not None and _holds(context.area, event.mouse_x, event.mouse_y)
        try:
            placed = inside or dragging.drop(context, event.mouse_x, event.mouse_y)
        except RuntimeError as error:  # what the operator has reported as an error
            self.report({"ERROR"}, str(error).removeprefix("Error: ").strip())
            return {"CANCELLED"}
        if not placed:
            self.report({"INFO"}, tr("Drop the match in a 3D view of this window to place it there"))
        return {"FINISHED"}


def _holds(box: Any, x: float, y: float) -> bool:
    return bool(0 <= x - box.x < box.width and 0 <= y - box.y < box.height)


def use(operator: Any, context: Any) -> None:
    """Append the chosen match; select one that is in the scene."""
    match = active_match(context)
    if match is None:
        return
    try:
        if match.in_scene:
            bpy.ops.shape_google.select_match("EXEC_DEFAULT", True)
        else:
            bpy.ops.shape_google.append_match("EXEC_DEFAULT", True)
    except RuntimeError as error:  # what the operator has reported as an error
        operator.report({"ERROR"}, str(error).removeprefix("Error: ").strip())


def resize(context: Any, steps: int) -> None:
    """Make the pictures larger or smaller; what is seen first stays in view."""
    session, view = session_of(context), state.current().gallery.view
    _, grid, indices = parts(context)
    first = grid.visible(view.scroll).start
    size = session.picture_size + steps * _ZOOM
    session.picture_size = min(max(size, SMALLEST_PICTURE), LARGEST_PICTURE)
    if indices:
        _, grid, _ = parts(context)
        view.scroll = grid.clamped(first // grid.columns * grid.cell_height)
    context.area.tag_redraw()


class SHAPEGOOGLE_OT_gallery_hover(InGallery, bpy.types.Operator):
    """Show what is known of the match under the pointer."""

    bl_idname = "shape_google.gallery_hover"
    bl_label = "Look at Match"
    bl_description = "Show what is known of the match under the pointer"

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Note it, and let the event go on."""
        view = state.current().gallery.view
        hovered = match_at(context, event.mouse_region_x, event.mouse_region_y)
        if hovered != view.hovered:
            view.hovered = hovered
            context.area.tag_redraw()
        return {"PASS_THROUGH"}


class SHAPEGOOGLE_OT_gallery_scroll(InGallery, bpy.types.Operator):
    """Scroll the gallery, or change the size of its pictures."""

    bl_idname = "shape_google.gallery_scroll"
    bl_label = "Scroll Gallery"
    bl_description = "Scroll the gallery, or change the size of its pictures"

    step: EnumProperty(
        items=(
            ("UP", "Up", "Scroll up"),
            ("DOWN", "Down", "Scroll down"),
            ("LARGER", "Larger", "Larger pictures"),
            ("SMALLER", "Smaller", "Smaller pictures"),
            ("PAN", "Trackpad", "As far as two fingers have moved"),
        ),
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Scroll."""
        view = state.current().gallery.view
        if view.comparison is not None:
            from ..compare.turning import turned, zoomed

            shown = view.comparison
            if self.step == "PAN":
                scale = context.preferences.system.ui_scale
                right, up = event.mouse_x - event.mouse_prev_x, event.mouse_y - event.mouse_prev_y
                shown.direction = turned(shown.direction, right / scale, up / scale)
            else:
                shown.zoom = zoomed(shown.zoom, 1 if self.step in ("UP", "LARGER") else -1)
        elif self.step in ("LARGER", "SMALLER"):
            resize(context, 1 if self.step == "LARGER" else -1)
        else:
            _, grid, _ = parts(context)
            wheel = _WHEEL * context.preferences.system.ui_scale
            moved = {"UP": -wheel, "DOWN": wheel}.get(self.step, event.mouse_y - event.mouse_prev_y)
            view.scroll = grid.clamped(view.scroll + moved)
            view.hovered = match_at(context, event.mouse_region_x, event.mouse_region_y)
        context.area.tag_redraw()
        return {"FINISHED"}


class SHAPEGOOGLE_OT_gallery_key(InGallery, bpy.types.Operator):
    """Choose a match by the arrow keys, use it, or close the gallery."""

    bl_idname = "shape_google.gallery_key"
    bl_label = "Use Gallery by Keys"
    bl_description = "Choose a match by the arrow keys, use it, or close the gallery"

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Do what the key means."""
        view, session = state.current().gallery.view, session_of(context)
        if event.type == "ESC":
            self._leave(context)
        elif view.comparison is not None:
            return {"PASS_THROUGH"}
        elif event.type in ("RET", "NUMPAD_ENTER"):
            use(self, context)
        elif event.type in ("NUMPAD_PLUS", "NUMPAD_MINUS", "EQUAL", "MINUS"):
            resize(context, 1 if event.type in ("NUMPAD_PLUS", "EQUAL") else -1)
        else:
            _, grid, indices = parts(context)
            _, active = shown_lines(session)
            place = indices.index(active) if active in indices else -1
            target = grid.step(place, event.type)
            if target >= 0:
                choose(indices[target])
                view.scroll = grid.shown(target, view.scroll)
        if context.area is not None:
            context.area.tag_redraw()
        return {"FINISHED"}

    def _leave(self, context: Any) -> None:
        """One step back: from the comparison, the versions, the text; last close the area."""
        view, session = state.current().gallery.view, session_of(context)
        if view.comparison is not None:
            view.comparison = None
        elif session.opened >= 0:
            bpy.ops.shape_google.show_versions("INVOKE_DEFAULT", index=-1)
        elif session.text:
            session.text = ""
        else:
            area.close(context.window, context.area)


class SHAPEGOOGLE_OT_gallery_menu(InGallery, bpy.types.Operator):
    """Show what can be done with the match under the pointer."""

    bl_idname = "shape_google.gallery_menu"
    bl_label = "Match Menu"
    bl_description = "Show what can be done with the match under the pointer"

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Choose the match, and open the menu."""
        if state.current().gallery.view.comparison is None:
            index = match_at(context, event.mouse_region_x, event.mouse_region_y)
            if index < 0:
                return {"FINISHED"}
            choose(index)
            context.area.tag_redraw()
        bpy.ops.wm.call_menu(name="SHAPEGOOGLE_MT_match")
        return {"FINISHED"}


class SHAPEGOOGLE_OT_gallery_compare(InGallery, bpy.types.Operator):
    """Compare the chosen match with the query."""

    bl_idname = "shape_google.gallery_compare"
    bl_label = "Compare in Gallery"
    bl_description = "Compare the chosen match with the query"

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Compare them, or show the pictures again."""
        view = state.current().gallery.view
        if view.comparison is not None:
            view.comparison = None
            context.area.tag_redraw()
        elif bpy.ops.shape_google.compare_match.poll():
            bpy.ops.shape_google.compare_match("INVOKE_DEFAULT")
        return {"FINISHED"}


_CLASSES = (
    SHAPEGOOGLE_OT_gallery_press,
    SHAPEGOOGLE_OT_gallery_hover,
    SHAPEGOOGLE_OT_gallery_scroll,
    SHAPEGOOGLE_OT_gallery_key,
    SHAPEGOOGLE_OT_gallery_menu,
    SHAPEGOOGLE_OT_gallery_compare,
)
register, unregister = bpy.utils.register_classes_factory(_CLASSES)
