# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw a surface in colours into a picture on the graphics card.

The region of the gallery has no depth buffer, so that a surface is drawn into a picture of its own, which
has one. Light and turning are computed here, for a few thousand faces: the shaders that Blender brings do the
rest on every graphics card and in every version.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import gpu
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from shapegoogle_core.worker.comparison import ComparedSurface

__all__ = ["Prepared", "prepare", "render"]

# Directions towards the light and a weaker one on the other side, as (right, up, towards the viewer).
_KEY, _FILL = (-0.45, 0.65, 0.61), (0.75, 0.1, 0.65)
# Half the side of the square that shows a point, as a share of the side of the picture.
_POINT = 0.006
# Samples per pixel along each side.
_FINER, _MOST_PIXELS = 2, 2_500_000


@dataclass(frozen=True, eq=False)
class Prepared:
    """A surface as it is drawn.

    Attributes
    ----------
    corners : (n, 3) array
        Of triangles without common corners; or points.
    normals : (n, 3) array or None
        None for points.
    colors : (n, 3) array
    """

    corners: NDArray[Any]
    normals: NDArray[Any] | None
    colors: NDArray[Any]


def prepare(surface: ComparedSurface, most: float) -> Prepared:
    """Colour a surface by its distances.

    Parameters
    ----------
    surface : ComparedSurface
    most : float
        Distance of the last colour.

    Returns
    -------
    prepared : Prepared
    """
    import numpy as np

    colors = distance_colors(surface.distances, most)
    if not len(surface.faces):
        return Prepared(surface.vertices, None, colors)
    corners = surface.vertices[surface.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(np.float32).tiny)
    return Prepared(
        corners.reshape(-1, 3), np.repeat(normals, 3, axis=0), colors[surface.faces].reshape(-1, 3)
    )


def distance_colors(distances: Any, most: float) -> NDArray[Any]:
    """Return the colours of distances, from blue for none to yellow.

    Parameters
    ----------
    distances : (n,) array_like
    most : float
        Distance from which the colour stays the same.

    Returns
    -------
    colors : (n, 3) array
        sRGB from 0 to 1.
    """
    from shapegoogle_core.rendering import value_colors

    # Not from the darkest colours on: what fits must be seen too.
    return value_colors(distances, low=-0.6 * most, high=most)


def render(prepared: Prepared, rotation: Any, scale: float, width: int, height: int) -> Any | None:
    """Draw a surface into a picture.

    Parameters
    ----------
    prepared : Prepared
    rotation : (3, 3) array_like
        Rows point right, up and towards the viewer.
    scale : float
        Pixels per unit of the surface.
    width, height : int
        In pixels.

    Returns
    -------
    picture : gpu.types.GPUTexture or None
        Twice as large, for smooth edges. None if the graphics card has no room for it.
    """
    import numpy as np

    turn = np.asarray(rotation, np.float32)
    points = prepared.corners @ turn.T
    across = np.array([2 * scale / width, 2 * scale / height], np.float32)
    # Of the depth that is drawn.
    farthest = float(np.abs(points[:, 2]).max(initial=0)) * 1.01 or 1.0
    colors = prepared.colors
    if prepared.normals is None:
        depth = points[:, 2] / farthest
        colors = colors * (0.7 + 0.3 * np.clip(depth, -1, 1))[:, None]
        points, colors = _squares(points, _POINT * min(width, height) / scale), np.repeat(colors, 6, axis=0)
    else:
        colors = colors * _light(prepared.normals @ turn.T)[:, None]
    places = np.concatenate([points[:, :2] * across, -points[:, 2:] / farthest], axis=1)
    rgba = np.concatenate([np.clip(colors, 0, 1), np.ones((len(colors), 1))], axis=1)
    finer = _FINER if _FINER**2 * width * height <= _MOST_PIXELS else 1
    size = finer * width, finer * height
    try:
        # No GPUOffScreen: to make one while a region is drawn ends the drawing of the region.
        picture = gpu.types.GPUTexture(size, format="SRGB8_A8")
        depths = gpu.types.GPUTexture(size, format="DEPTH_COMPONENT32F")
        target = gpu.types.GPUFrameBuffer(depth_slot=depths, color_slots=(picture,))
    except (RuntimeError, ValueError):  # no room on the graphics card, or larger than it allows
        return None
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    content = {
        "pos": np.ascontiguousarray(places, np.float32),
        "color": np.ascontiguousarray(rgba, np.float32),
    }
    batch = batch_for_shader(shader, "TRIS", content)
    with target.bind():
        target.clear(color=(0, 0, 0, 0), depth=1)
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.depth_mask_set(True)
        gpu.state.blend_set("NONE")
        with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
            gpu.matrix.load_matrix(Matrix.Identity(4))
            gpu.matrix.load_projection_matrix(Matrix.Identity(4))
            batch.draw(shader)
        gpu.state.depth_mask_set(False)
        gpu.state.depth_test_set("NONE")
    return picture


def _light(normals: NDArray[Any]) -> NDArray[Any]:
    """Shade with two lights; both sides of a face are lit."""
    import numpy as np

    normals = np.where(normals[:, 2:] < 0, -normals, normals)
    key, fill = (np.array(light) / np.linalg.norm(light) for light in (_KEY, _FILL))
    lit = 0.45 + 0.5 * np.maximum(normals @ key, 0) + 0.15 * np.maximum(normals @ fill, 0)
    return np.asarray(lit)


def _squares(points: NDArray[Any], half: float) -> NDArray[Any]:
    """Make two triangles, seen from the front, of each point."""
    import numpy as np

    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]], np.float32)
    corners = np.repeat(points, 6, axis=0)
    corners[:, :2] += half * np.tile(signs, (len(points), 1))
    return corners
