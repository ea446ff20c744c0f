# SPDX-License-Identifier: GPL-3.0-or-later
"""Drag a match out of the gallery, and place it where it is dropped."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import bpy
from bpy.props import FloatVectorProperty

from ... import state
from ...scene.selection import collection_for_new
from ...translation import error_text, tr
from .. import finding, placing
from ..errors import PlacingError
from ..on_match import OnMatch, active_match
from . import area, textures
from .layout import Box
from .painting import Painter
from .place import place_under, view_under

__all__ = ["Dragged", "begin", "drop", "end", "move", "register", "unregister"]

# Of the picture that follows the pointer, at a scale of 1.
_SIDE, _STRENGTH = 128, 0.8


@dataclass
class Dragged:
    """A match that is being dragged.

    Attributes
    ----------
    shape_id : int
    x, y : int
        Where the pointer is, in pixels from the lower left corner of the window.
    handles : list
        Blender's handles of the functions that draw the picture at the pointer, with their kinds of spaces.
    """

    shape_id: int
    x: int
    y: int
    handles: list[tuple[Any, object]] = field(default_factory=list)


class SHAPEGOOGLE_OT_drop_match(OnMatch, bpy.types.Operator):
    """Place the match."""

    bl_idname = "shape_google.drop_match"
    bl_label = "Place Match"
    bl_description = (
        "Place the match in the scene: append it, or copy it if it is in the scene already, with the middle "
        "of its underside at a location"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    location: FloatVectorProperty(
        name="Location", description="Where the middle of its underside goes", subtype="TRANSLATION"
    )

    def execute(self, context: Any) -> set[str]:
        """Place it."""
        match = active_match(context)
        try:
            here = finding.object_of(context, match)
            if here is None:
                objects = placing.bring_in(context, match.source, finding.sought(match))
            else:
                objects = _copies(context, match, here)
        except PlacingError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        placing.move_to(objects, self.location)
        state.current().gallery.placed.update(item.session_uid for item in objects)
        self.report({"INFO"}, tr("Placed {name}").format(name=objects[0].name))
        return {"FINISHED"}


def _copies(context: Any, match: Any, here: Any) -> list[Any]:
    """Copy an object of the scene, or all objects of a collection; they share its data."""
    placing.to_object_mode(context)
    originals = finding.placements_here(context, match) if match.shape_type == "collection" else [here]
    copies = {item: item.copy() for item in originals}
    collection = collection_for_new(context)
    for item, copy in copies.items():
        collection.objects.link(copy)
        if item.parent in copies:
            copy.parent = copies[item.parent]
            copy.matrix_parent_inverse = item.matrix_parent_inverse
        elif item.parent is not None:
            copy.parent, copy.matrix_world = None, item.matrix_world
    context.view_layer.update()
    placing.select_only(context, list(copies.values()))
    return list(copies.values())


def begin(context: Any, shape_id: int, x: int, y: int) -> Dragged:
    """Show the picture of a match at the pointer.

    Parameters
    ----------
    context : bpy.types.Context
    shape_id : int
    x, y : int
        Of the pointer in the window.

    Returns
    -------
    dragged : Dragged
        For `move` and `end`.
    """
    dragged = state.current().gallery.dragged = Dragged(shape_id, x, y)
    for space in (bpy.types.SpaceView3D, bpy.types.SpaceNodeEditor):
        dragged.handles.append((space, space.draw_handler_add(_draw, (dragged,), "WINDOW", "POST_PIXEL")))
    context.window.cursor_modal_set("HAND")
    context.workspace.status_text_set(tr("Drop it in a 3D view to place it there  ·  Esc: cancel"))
    return dragged


def move(context: Any, dragged: Dragged, x: int, y: int) -> None:
    """Have the picture follow the pointer."""
    # Where it was and where it is now.
    for at in ((dragged.x, dragged.y), (x, y)):
        for each in context.window.screen.areas:
            if each.type in ("VIEW_3D", "NODE_EDITOR") and _near(each, *at, _SIDE * _scale(context)):
                each.tag_redraw()
    dragged.x, dragged.y = x, y


def end(context: Any, dragged: Dragged) -> None:
    """Show it no more."""
    for space, handle in dragged.handles:
        space.draw_handler_remove(handle, "WINDOW")
    if state.is_registered():
        state.current().gallery.dragged = None
    for window in context.window_manager.windows:
        window.cursor_modal_restore()
        window.workspace.status_text_set(None)
        for each in window.screen.areas:
            each.tag_redraw()


def drop(context: Any, x: int, y: int) -> bool:
    """Place the dragged match where the pointer is.

    Parameters
    ----------
    context : bpy.types.Context
    x, y : int
        Of the pointer in the window.

    Returns
    -------
    placed : bool
        False where there is no 3D view.
    """
    view = view_under(context.window, x, y)
    if view is None:
        return False
    location = place_under(context, view, x, y)
    with context.temp_override(window=context.window, area=view.area, region=view.region):
        # With a step of its own to undo.
        bpy.ops.shape_google.drop_match("INVOKE_DEFAULT", True, location=location)
    return True


def _scale(context: Any) -> float:
    return float(context.preferences.system.ui_scale)


def _near(each: Any, x: int, y: int, reach: float) -> bool:
    return bool(-reach <= x - each.x < each.width + reach and -reach <= y - each.y < each.height + reach)


def _draw(dragged: Dragged) -> None:
    """Draw the picture so that it stands on the pointer, in every region that it reaches into."""
    context = bpy.context
    region = context.region
    if context.area.type == "NODE_EDITOR" and not area.is_gallery(context.area):
        return
    texture = textures.texture_of(dragged.shape_id)
    if texture is None:
        return
    painter = Painter(context)
    side = _SIDE * painter.scale
    x, y = dragged.x - region.x, dragged.y - region.y
    painter.image(Box(x - side / 2, y, x + side / 2, y + side), texture, _STRENGTH)


register, _unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_OT_drop_match,))


def unregister() -> None:
    """Unregister the operator, and show what is being dragged no more: Blender does not tell who drags it."""
    dragged = state.current().gallery.dragged
    if dragged is not None:
        end(bpy.context, dragged)
    _unregister()
