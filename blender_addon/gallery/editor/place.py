# SPDX-License-Identifier: GPL-3.0-or-later
"""Where in the scene a place on the screen is."""

from __future__ import annotations

from typing import Any

from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d
from mathutils import Vector
from mathutils.geometry import intersect_line_plane

__all__ = ["View", "place_under", "view_under"]

# The floor is used unless it is seen nearly edge-on.
_LEAST_SLOPE = 0.05


class View:
    """A region that shows the scene.

    Parameters
    ----------
    area, region, region_data : bpy.types.Area, Region, RegionView3D
    """

    def __init__(self, area: Any, region: Any, region_data: Any) -> None:
        self.area, self.region, self.region_data = area, region, region_data


def view_under(window: Any, x: float, y: float) -> View | None:
    """Find the 3D view at a place of a window.

    Parameters
    ----------
    window : bpy.types.Window
    x, y : float
        In pixels from its lower left corner.

    Returns
    -------
    view : View or None
        None where there is no 3D view, or a toolbar or sidebar covers it.
    """
    for area in window.screen.areas:
        if area.type != "VIEW_3D" or not _holds(area, x, y):
            continue
        if any(region.type != "WINDOW" and _holds(region, x, y) for region in area.regions):
            return None
        views = [region for region in area.regions if region.type == "WINDOW"]
        space = area.spaces.active
        # A view that is divided into four has a region for each.
        several = space.region_quadviews if len(space.region_quadviews) == len(views) else ()
        for index, region in enumerate(views):
            if _holds(region, x, y):
                return View(area, region, several[index] if several else space.region_3d)
    return None


def _holds(box: Any, x: float, y: float) -> bool:
    return bool(0 <= x - box.x < box.width and 0 <= y - box.y < box.height and box.width > 1)


def place_under(context: Any, view: View, x: float, y: float) -> Vector:
    """Return the place that is seen at a place of a window: on a surface, or else on the floor.

    Parameters
    ----------
    context : bpy.types.Context
    view : View
    x, y : float
        In pixels from the lower left corner of the window.

    Returns
    -------
    place : Vector
        Where neither is seen, in the plane through the 3D cursor that faces the viewer.
    """
    at = x - view.region.x, y - view.region.y
    origin = region_2d_to_origin_3d(view.region, view.region_data, at)
    direction = region_2d_to_vector_3d(view.region, view.region_data, at)
    return along_ray(context, origin, direction, view.area.spaces.active.clip_end)


def along_ray(context: Any, origin: Vector, direction: Vector, farthest: float) -> Vector:
    """Return where a line of sight ends.

    Parameters
    ----------
    context : bpy.types.Context
    origin, direction : Vector
        The direction has length 1.
    farthest : float
        Distance beyond which the floor is not seen.

    Returns
    -------
    place : Vector
    """
    hit, place, *_ = context.scene.ray_cast(context.evaluated_depsgraph_get(), origin, direction)
    if hit:
        return place
    if abs(direction.z) > _LEAST_SLOPE:
        floor = intersect_line_plane(origin, origin + direction, Vector(), Vector((0, 0, 1)))
        if floor is not None and 0 < (floor - origin).dot(direction) < farthest:
            return floor
    through = context.scene.cursor.location
    return intersect_line_plane(origin, origin + direction, through, direction)
