# SPDX-License-Identifier: MIT
"""Pictures of objects with Blender's Workbench renderer, in the colours of their colour attribute.

Needs the `bpy` module; works without a window or a graphics card.
"""

from __future__ import annotations

import ctypes
import sys
import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from shapegoogle_core.rendering import look_from

__all__ = ["missing_library", "photograph", "set_up_studio"]

FloatArray = NDArray[np.float64]

# From the left front and a little above: creatures stand on the xy plane and face -y.
_VIEW = look_from((1.0, -1.15, 0.5), up=(0, 0, 1))
_LIGHT = np.array([0.0, -0.35, 1.1])  # towards the light, in world axes; steep, so that shadows stay near
_LIGHT_LOSS = 1.62  # factor by which the studio light darkens the (linear) colour of a level floor
_MARGIN = 0.05  # free on each side, as a share of the picture
_FLOOR_REACH = 40.0  # extent of the floor in sizes of the object, beyond the picture


def missing_library() -> str | None:
    """Return the system library that Workbench needs and that is missing; rendering without it would crash.

    Returns
    -------
    name : str or None
        None if nothing is missing.
    """
    if not sys.platform.startswith("linux"):
        return None
    name = "libEGL.so.1"
    try:
        ctypes.CDLL(name)
    except OSError:
        return name
    return None


def set_up_studio(scene: Any) -> None:
    """Set up a scene for Workbench, with objects in the colours of their active colour attribute.

    Parameters
    ----------
    scene : bpy.types.Scene
    """
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"  # keeps colours unchanged
    scene.render.dither_intensity = 0  # noise makes files larger
    scene.display.render_aa = "16"
    # Blender expects the direction from the light, with y up.
    scene.display.light_direction = (_LIGHT / np.linalg.norm(_LIGHT))[[0, 2, 1]] * [1, 1, -1]
    shading = scene.display.shading
    shading.light = "STUDIO"
    shading.studio_light = "paint.sl"  # even light from all sides changes colours least
    shading.color_type = "VERTEX"
    shading.show_shadows = True
    shading.shadow_intensity = 0.3
    shading.show_cavity = False
    shading.show_specular_highlight = True


def photograph(item: Any, size: tuple[int, int], floor: ArrayLike = (0.96, 0.96, 0.97)) -> Image.Image:
    """Render one object of the scene on a floor, with its shadow, filling the picture.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object in the context's scene. Other objects are hidden.
    size : (width, height)
        In pixels.
    floor : (3,) array_like
        Colour of the floor, sRGB in 0…1.

    Returns
    -------
    image : PIL.Image.Image
        "RGB".
    """
    scene = bpy.context.scene
    hidden = [other for other in scene.objects if other is not item and not other.hide_render]
    place = item.matrix_world.copy()
    # Workbench does not draw shadows of small objects, so all are scaled to the same size.
    item.matrix_world = Matrix.Scale(1 / float(np.ptp(_world_vertices(item), axis=0).max()), 4) @ place
    points = _world_vertices(item)
    made = [_add_floor(points, np.asarray(floor, float)), _add_camera(points, size)]
    for other in hidden:
        other.hide_render = True
    try:
        scene.camera = made[1]
        scene.render.resolution_x, scene.render.resolution_y = size
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "picture.png"
            scene.render.filepath = str(path)
            bpy.ops.render.render(write_still=True)
            return Image.open(path).convert("RGB")
    finally:
        item.matrix_world = place
        for other in hidden:
            other.hide_render = False
        for other in made:
            data = other.data
            bpy.data.objects.remove(other)
            bpy.data.batch_remove([data])


def _world_vertices(item: Any) -> FloatArray:
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    data = evaluated.to_mesh()
    vertices = np.empty((len(data.vertices), 3), np.float32)
    data.vertices.foreach_get("co", vertices.ravel())
    evaluated.to_mesh_clear()
    matrix = np.array(evaluated.matrix_world)
    points: FloatArray = vertices @ matrix[:3, :3].T + matrix[:3, 3]
    return points


def _add_floor(points: FloatArray, color: FloatArray) -> Any:
    """Add a floor under some points."""
    low, high = points.min(axis=0), points.max(axis=0)
    reach = _FLOOR_REACH * float((high - low).max())
    x, y = (low + high)[:2] / 2
    corners = [(x + i * reach, y + j * reach, low[2]) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    data = bpy.data.meshes.new("Floor")
    data.from_pydata(corners, [], [(0, 1, 2, 3)])
    attribute = data.color_attributes.new("Color", "FLOAT_COLOR", "POINT")
    attribute.data.foreach_set("color", np.tile([*(_LIGHT_LOSS * color**2.2), 1.0], 4))
    data.color_attributes.active_color = attribute
    floor = bpy.data.objects.new("Floor", data)
    bpy.context.scene.collection.objects.link(floor)
    return floor


def _add_camera(points: FloatArray, size: tuple[int, int]) -> Any:
    """Add a camera in which some points and their shadows on the floor fill the picture."""
    shadows = points - np.outer((points[:, 2] - points[:, 2].min()) / _LIGHT[2], _LIGHT)
    seen = np.concatenate([points, shadows]) @ _VIEW.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    width, height, depth = high - low
    pixels = (1 - 2 * _MARGIN) * min(size[0] / width, size[1] / height)
    data = bpy.data.cameras.new("Camera")
    data.type = "ORTHO"
    data.ortho_scale = max(size) / pixels
    data.clip_start, data.clip_end = 0.01 * depth, 10 * (_FLOOR_REACH + 1) * depth
    camera = bpy.data.objects.new("Camera", data)
    place = np.array([*(low + high)[:2] / 2, high[2] + depth]) @ _VIEW
    camera.matrix_world = Matrix.Translation(place) @ Matrix(_VIEW.T.tolist()).to_4x4()
    bpy.context.scene.collection.objects.link(camera)
    return camera
