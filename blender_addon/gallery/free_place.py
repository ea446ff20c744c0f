# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a match is placed: at the 3D cursor or beside the query, and never inside it or an earlier match."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mathutils import Vector

from .. import state
from ..scene.selection import mesh_objects, meshes_of
from . import placing

__all__ = ["put_at_cursor", "put_beside", "query_parts"]

# Gap between two shapes side by side, as a share of their widths.
GAP = 0.2

Box = tuple[Vector, Vector]


def query_parts(context: Any) -> list[Any]:
    """Return the objects that the last search was made with, as far as they are still there.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    parts : list of bpy.types.Object
        Those of the active object if none of them is left, or the query was no object.
    """
    search, placed = state.current().search, state.current().gallery.placed
    parts = [item for item in context.view_layer.objects if item.session_uid in search.searched]
    active = context.active_object
    if not parts and active is not None and active.session_uid not in placed:
        parts = meshes_of(active, context)
        # The next match, when the one placed now is active, must not be put inside it either.
        search.searched = frozenset(part.session_uid for part in parts)
    return parts


def put_at_cursor(context: Any, objects: Sequence[Any], parts: Sequence[Any]) -> None:
    """Move new objects to the 3D cursor; where they would overlap the query or earlier matches, beside these.

    Parameters
    ----------
    context : bpy.types.Context
    objects : sequence of bpy.types.Object
        As from `placing.bring_in`.
    parts : sequence of bpy.types.Object
        The query; see `query_parts`.
    """
    _put(context, objects, parts, Vector(context.scene.cursor.location))


def put_beside(context: Any, objects: Sequence[Any], parts: Sequence[Any]) -> None:
    """Move new objects beside the query and the matches that are there already.

    Parameters
    ----------
    context : bpy.types.Context
    objects : sequence of bpy.types.Object
        As from `placing.bring_in`.
    parts : sequence of bpy.types.Object
        At least one; see `query_parts`.
    """
    low, high = _box(parts)
    _put(context, objects, parts, Vector(((low.x + high.x) / 2, (low.y + high.y) / 2, low.z)))


def _put(context: Any, objects: Sequence[Any], parts: Sequence[Any], place: Vector) -> None:
    context.view_layer.update()
    placed = state.current().gallery.placed
    earlier = [item for item in context.view_layer.objects if item.session_uid in placed]
    # Each earlier match on its own: there may be room between them. The query is one thing.
    obstacles = [_box([item]) for item in earlier if item not in objects]
    if parts:
        obstacles.append(_box(parts))
    low, high = _box(mesh_objects(objects) or objects)
    first_low, first_high = placing.bounds(objects[0])
    # `move_to` puts the bottom centre of the first one there.
    anchor = Vector(((first_low.x + first_high.x) / 2, (first_low.y + first_high.y) / 2, first_low.z))
    low, high = low + place - anchor, high + place - anchor
    for _ in obstacles:
        hit = [box for box in obstacles if _overlap((low, high), box)]
        if not hit:
            break
        other_low, other_high = max(hit, key=lambda box: box[1].x)
        gap = GAP * (other_high.x - other_low.x + high.x - low.x) / 2
        step = Vector((other_high.x + gap - low.x, 0, 0))
        low, high, place = low + step, high + step, place + step
    placing.move_to(list(objects), place)
    placed.update(item.session_uid for item in mesh_objects(objects))


def _box(items: Sequence[Any]) -> Box:
    """Box around all objects, modifiers included."""
    corners = [corner for item in items for corner in placing.bounds(item)]
    low = Vector(min(corner[axis] for corner in corners) for axis in range(3))
    high = Vector(max(corner[axis] for corner in corners) for axis in range(3))
    return low, high


def _overlap(one: Box, other: Box) -> bool:
    """Whether two boxes share more than rounding would explain; flat ones may."""
    least = 1e-5 * max((one[1] - one[0]).length, (other[1] - other[0]).length)
    return all(
        one[0][axis] < other[1][axis] - least and other[0][axis] < one[1][axis] - least for axis in range(2)
    ) and (one[0].z <= other[1].z and other[0].z <= one[1].z)
