# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the bars and buttons of the gallery are, and how texts fit: arithmetic without Blender.

Lengths are pixels; y grows upwards, as in Blender's regions. `scale` is the scale of the interface.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

__all__ = [
    "LARGEST_PICTURE",
    "SMALLEST_PICTURE",
    "Bars",
    "Box",
    "arrange",
    "fitted",
    "shortened",
    "unobstructed",
]

SMALLEST_PICTURE, LARGEST_PICTURE = 96, 256
# At a scale of 1.
_GAP, _BAR, _STATUS, _BUTTON = 8, 30, 24, 24
_CORNER = 28
_LONGEST_FIELD = 480


@dataclass(frozen=True)
class Box:
    """An upright rectangle.

    Attributes
    ----------
    left, bottom, right, top : float
        Empty if right is not above left, or top not above bottom.
    """

    left: float
    bottom: float
    right: float
    top: float

    @property
    def width(self) -> float:
        """Its width, 0 if it is empty."""
        return max(0.0, self.right - self.left)

    @property
    def height(self) -> float:
        """Its height, 0 if it is empty."""
        return max(0.0, self.top - self.bottom)

    def holds(self, x: float, y: float) -> bool:
        """Whether a point is inside."""
        return self.left <= x < self.right and self.bottom <= y < self.top

    def shrunk(self, margin: float) -> Box:
        """Return the box without a margin on all sides."""
        return Box(self.left + margin, self.bottom + margin, self.right - margin, self.top - margin)


@dataclass(frozen=True)
class Bars:
    """What surrounds the pictures.

    Attributes
    ----------
    search : Box
        The search field.
    clear : Box
        The button inside it that empties it.
    smaller, larger, close : Box
        Buttons.
    count : Box
        Where the number of matches is written, or the button that leads back from versions; empty if there
        is no room.
    content : Box
        Where the pictures are.
    status : Box
        The line at the bottom that describes a match.
    """

    search: Box
    clear: Box
    smaller: Box
    larger: Box
    close: Box
    count: Box
    content: Box
    status: Box

    def button_at(self, x: float, y: float) -> str | None:
        """Return the name of the button at a place: one of the attributes, or None."""
        for name in ("clear", "search", "smaller", "larger", "close", "count"):
            if getattr(self, name).holds(x, y):
                return name
        return None


def arrange(area: Box, scale: float) -> Bars:
    """Divide an area into the bar at the top, the pictures, and the line at the bottom.

    Parameters
    ----------
    area : Box
    scale : float

    Returns
    -------
    bars : Bars
        In an area that is too small for them, what matters less is empty.
    """
    gap, button = _GAP / 2 * scale, _BUTTON * scale
    top = area.top - (_BAR - _BUTTON) / 2 * scale
    bottom = top - button
    # In the corner Blender shows the arrow that brings a hidden header back.
    right = area.right - _CORNER * scale
    close = Box(right - button, bottom, right, top)
    larger = Box(close.left - 2 * gap - button, bottom, close.left - 2 * gap, top)
    smaller = Box(larger.left - button, bottom, larger.left, top)
    room = smaller.left - 2 * gap - (area.left + gap)
    width = min(room, _LONGEST_FIELD * scale)
    search = Box(area.left + gap, bottom, area.left + gap + width, top)
    clear = Box(search.right - button, bottom, search.right, top)
    count = Box(search.right + 2 * gap, bottom, smaller.left - 2 * gap, top)
    low = area.bottom + _STATUS * scale
    # Little room is for pictures.
    status = Box(area.left, area.bottom, area.right, low if area.height > 8 * _BAR * scale else area.bottom)
    content = Box(area.left, status.top, area.right, area.top - _BAR * scale)
    return Bars(search, clear, smaller, larger, close, count, content, status)


def unobstructed(width: float, height: float, sides: Iterable[tuple[str, float]]) -> Box:
    """Return what of a region no other region covers.

    Parameters
    ----------
    width, height : float
        Of the region.
    sides : iterable of (str, float)
        The side that a region on top of it is at, as Blender names alignments, and its width or height.

    Returns
    -------
    box : Box
    """
    left, bottom, right, top = 0.0, 0.0, width, height
    for side, size in sides:
        if size <= 1:  # hidden
            continue
        if side == "LEFT":
            left += size
        elif side == "RIGHT":
            right -= size
        elif side == "BOTTOM":
            bottom += size
        elif side == "TOP":
            top -= size
    return Box(left, bottom, max(right, left), max(top, bottom))


def shortened(text: str, width: float, measure: Callable[[str], float]) -> str:
    """Cut a text so that it fits into a width, with an ellipsis in its middle: both ends may tell it apart.

    Parameters
    ----------
    text : str
    width : float
    measure : callable
        Returns the width of a text.

    Returns
    -------
    text : str
        Empty if not even the ellipsis fits.
    """
    if measure(text) <= width:
        return text
    fewest, most = -1, len(text) - 1
    while fewest < most:  # the largest number of letters that fit
        middle = math.ceil((fewest + most) / 2)
        if measure(_cut(text, middle)) <= width:
            fewest = middle
        else:
            most = middle - 1
    return _cut(text, fewest) if fewest >= 0 else ""


def _cut(text: str, letters: int) -> str:
    end = letters // 3
    return f"{text[: letters - end].rstrip()}…{text[len(text) - end :] if end else ''}"


def fitted(box: Box, width: float, height: float) -> Box:
    """Return the largest box of given proportions in the middle of a box."""
    factor = min(box.width / width, box.height / height)
    x, y = (box.left + box.right) / 2, (box.bottom + box.top) / 2
    across, along = factor * width / 2, factor * height / 2
    return Box(x - across, y - along, x + across, y + along)
