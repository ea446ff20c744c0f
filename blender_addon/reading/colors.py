# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour that an object has in a picture: that of the material of most of its faces."""

from __future__ import annotations

from collections import Counter
from typing import Any

__all__ = ["color_of"]

# Black on a dark interface would not be seen.
_DARKEST = 0.3


def color_of(item: Any) -> tuple[float, float, float] | None:
    """Return the colour of an object, without reading textures.

    Parameters
    ----------
    item : bpy.types.Object

    Returns
    -------
    color : (float, float, float) or None
        sRGB from 0 to 1. None without a material, and where a texture or other nodes give the colour.
    """
    slots = item.material_slots
    if not slots:
        return None
    index = 0
    if item.type == "MESH" and len(slots) > 1 and item.data.polygons:
        indices = [0] * len(item.data.polygons)
        item.data.polygons.foreach_get("material_index", indices)
        index = Counter(indices).most_common(1)[0][0]
    material = slots[min(index, len(slots) - 1)].material
    linear = None if material is None else _base_color(material)
    return None if linear is None else _shown(linear)


def _base_color(material: Any) -> tuple[float, float, float] | None:
    """Return the linear colour of a material; None if it is not one colour."""
    # Later versions of Blender have no materials without nodes.
    if material.node_tree is None or not getattr(material, "use_nodes", True):
        return tuple(material.diffuse_color[:3])
    for node in material.node_tree.nodes:
        if node.type == "BSDF_PRINCIPLED":
            socket = node.inputs["Base Color"]
        elif node.type in ("BSDF_DIFFUSE", "EMISSION"):
            socket = node.inputs["Color"]
        else:
            continue
        return None if socket.is_linked else tuple(socket.default_value[:3])
    return None


def _shown(linear: tuple[float, float, float]) -> tuple[float, float, float]:
    red, green, blue = (_DARKEST + (1 - _DARKEST) * _encoded(min(max(value, 0.0), 1.0)) for value in linear)
    return red, green, blue


def _encoded(value: float) -> float:
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055
