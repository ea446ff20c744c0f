# SPDX-License-Identifier: GPL-3.0-or-later
"""How far heat has spread on an object, in words: the text below the time slider."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import bpy

from .. import state
from ..translation import tr
from .choices import Painting

__all__ = ["TimeRange", "distance_text", "scale_text"]


@dataclass(frozen=True)
class TimeRange:
    """Range of times of a painted object.

    Attributes
    ----------
    shortest, longest : float
        In squared world units; see `shapegoogle_core.descriptors.time_range`.
    size : float
        Diagonal of the object's bounding box in world units.
    """

    shortest: float
    longest: float
    size: float


def scale_text(item: Any, chosen: Painting, units: Any) -> str:
    """How far heat has spread on an object at the time of the slider.

    Parameters
    ----------
    item : bpy.types.Object
    chosen : Painting
    units : bpy.types.UnitSettings

    Returns
    -------
    text : str
        Such as "0.12 m · 3.4 % of its size"; empty for an object that was not painted since the file
        was opened.
    """
    known = state.current().signature.times.get(item.session_uid)
    if known is None:
        return ""
    time = known.shortest * (known.longest / known.shortest) ** chosen.scale
    return distance_text(math.sqrt(time), known.size, units)


def distance_text(distance: float, size: float, units: Any) -> str:
    """Write a distance in the scene's units and as a share of an object's size.

    Parameters
    ----------
    distance, size : float
        In world units.
    units : bpy.types.UnitSettings

    Returns
    -------
    text : str
    """
    if units.system == "NONE":  # for which Blender's own function crashes
        length = f"{distance:.3g}"
    else:
        length = bpy.utils.units.to_string(
            units.system, "LENGTH", distance * units.scale_length, precision=3, compatible_unit=True
        )
    if size <= 0:
        return str(length)
    text = tr("{length} · {share:.1f} % of its size")
    return text.format(length=length, share=100 * distance / size)
