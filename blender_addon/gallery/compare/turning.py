# SPDX-License-Identifier: GPL-3.0-or-later
"""From where the two surfaces of a comparison are seen: arithmetic without Blender."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

__all__ = ["Direction", "pixels_per_unit", "rounded_up", "rows", "turned", "zoomed"]

# Radians per pixel at a scale of the interface of 1, and the factor of a step of the wheel.
_PER_PIXEL, _STEP = 0.01, 1.15
_CLOSEST, _FARTHEST = 8.0, 0.4
_STEEPEST = math.pi / 2
# What ends a scale, times a power of ten. A little more than that is the same.
_ROUND, _ALMOST = (1, 1.5, 2, 3, 4, 5, 7, 10), 0.98


@dataclass(frozen=True)
class Direction:
    """Where the viewer is, as on a turntable.

    Attributes
    ----------
    around : float
        Angle around the vertical axis, 0 in front, in radians.
    above : float
        Angle above the horizon.
    """

    around: float = math.radians(35)
    above: float = math.radians(20)


def turned(direction: Direction, right: float, up: float) -> Direction:
    """Turn by a movement of the pointer.

    Parameters
    ----------
    direction : Direction
    right, up : float
        In pixels at a scale of 1.

    Returns
    -------
    direction : Direction
        Never upside down.
    """
    above = min(max(direction.above - up * _PER_PIXEL, -_STEEPEST), _STEEPEST)
    return replace(direction, around=direction.around - right * _PER_PIXEL, above=above)


def zoomed(zoom: float, steps: int) -> float:
    """Come closer by steps of the wheel, within limits."""
    return min(max(zoom * _STEP**steps, _FARTHEST), _CLOSEST)


def rows(direction: Direction, up_axis: int) -> tuple[tuple[float, float, float], ...]:
    """Return the rotation of the world into the view.

    Parameters
    ----------
    direction : Direction
    up_axis : {1, 2}
        Axis that points up: y or z.

    Returns
    -------
    rows : ((float, float, float), ...)
        Directions to the right, upwards, and towards the viewer.
    """
    sine, cosine = math.sin(direction.around), math.cos(direction.around)
    rise, level = math.sin(direction.above), math.cos(direction.above)
    # With z up, the front is seen from -y.
    right = (cosine, sine, 0.0)
    toward = (level * sine, -level * cosine, rise)
    up = (-rise * sine, rise * cosine, level)
    if up_axis == 2:
        return right, up, toward
    return tuple((x, z, -y) for x, y, z in (right, up, toward))


def pixels_per_unit(direction: Direction, across: float, along: float, width: float, height: float) -> float:
    """Return the scale at which a shape fits into a picture, however it is turned around its vertical axis.

    Parameters
    ----------
    direction : Direction
    across, along : float
        Largest distance of the shape from the vertical axis, and from the plane through its centre.
    width, height : float
        Of the picture, in pixels.

    Returns
    -------
    scale : float
    """
    rise, level = abs(math.sin(direction.above)), math.cos(direction.above)
    high = along * level + across * rise
    smallest = 1e-9 * max(across, along, 1e-30)
    return min(width / 2 / max(across, smallest), height / 2 / max(high, smallest))


def rounded_up(value: float) -> float:
    """Return the next larger round number, for the end of a scale.

    Parameters
    ----------
    value : float

    Returns
    -------
    rounded : float
        1 for a value that is not positive.
    """
    if not value > 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(factor * power for factor in _ROUND if factor * power >= value * _ALMOST)
