# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw a comparison: both surfaces, what they are, and what the colours mean."""

from __future__ import annotations

from typing import Any

from ...state import session_of
from ...translation import tr
from .. import labels
from ..editor.area import bars_in
from ..editor.layout import Box
from ..editor.painting import Painter
from ..on_match import shown_lines
from .operators import length_text
from .shown import Shown
from .surfaces import distance_colors, prepare, render
from .turning import pixels_per_unit, rounded_up, rows

__all__ = ["draw_comparison"]

# At a scale of 1: line of text, gap, height and largest width of the bar of colours.
_LINE, _GAP, _BAR, _WIDEST = 20, 8, 14, 420
_STEPS = 48
# Share of a shape's size up to which distances are shown as small ones: simpler previews differ by less.
_LEAST_SCALE = 0.02
_MARGIN = 1.08


def draw_comparison(context: Any, painter: Painter, shown: Shown) -> None:
    """Draw a comparison over the whole region.

    Parameters
    ----------
    context : bpy.types.Context
    painter : Painter
    shown : Shown
    """
    bars = bars_in(context)
    gap, line = _GAP * painter.scale, _LINE * painter.scale
    # The right end of the bar above belongs to the button that closes.
    whole = Box(bars.status.left, bars.status.bottom, bars.status.right, bars.content.top)
    title = Box(whole.left + gap, bars.content.top, bars.close.left - gap, bars.close.top + gap / 2)
    painter.text(title, _title(context, shown), painter.theme.text)
    painter.box(bars.close, painter.theme.button)
    painter.text(bars.close, "×", painter.theme.text, "CENTER")
    legend = Box(whole.left + gap, whole.bottom + gap, whole.right - gap, whole.bottom + gap + 4 * line)
    halves = Box(whole.left + gap, legend.top + gap, whole.right - gap, whole.top)
    if shown.surfaces is None:
        text = shown.problem or tr("Comparing the surfaces …")
        painter.text(halves, text, painter.theme.faint, "CENTER")
        return
    most = _most(shown)
    if shown.prepared is None:
        shown.prepared = [prepare(surface, most) for surface in (shown.surfaces.query, shown.surfaces.match)]
    wide = halves.width >= halves.height
    middle = (halves.left + halves.right) / 2 if wide else (halves.bottom + halves.top) / 2
    if wide:
        boxes = (
            Box(halves.left, halves.bottom, middle - gap / 2, halves.top),
            Box(middle + gap / 2, halves.bottom, halves.right, halves.top),
        )
    else:
        boxes = (
            Box(halves.left, middle + gap / 2, halves.right, halves.top),
            Box(halves.left, halves.bottom, halves.right, middle - gap / 2),
        )
    names = tr("Query: {name}").format(name=shown.query), tr("Match: {name}").format(name=shown.match)
    for place, (box, name) in enumerate(zip(boxes, names, strict=True)):
        _draw_surface(painter, shown, place, box, name)
    _draw_legend(context, painter, shown, legend, most)


def _title(context: Any, shown: Shown) -> str:
    lines, _ = shown_lines(session_of(context))
    # The search may find the kind later than the comparison is shown.
    match = next((line for line in lines if line.shape_id == shown.shape_id), None)
    what = "" if match is None else labels.evidence_text(match, with_size=False)
    if shown.surfaces is not None and match is not None and f"{match.size:.3g}" != "1":
        size = tr("the match is ×{factor:.3g} as large, shown at the size of the query")
        what = f"{what}  ·  {size.format(factor=match.size)}" if what else size
    return what


def _most(shown: Shown) -> float:
    assert shown.surfaces is not None
    return rounded_up(max(shown.surfaces.most, _LEAST_SCALE * shown.surfaces.size))


def _draw_surface(painter: Painter, shown: Shown, place: int, box: Box, name: str) -> None:
    theme, line = painter.theme, _LINE * painter.scale
    painter.box(box, theme.cell)
    inside = Box(box.left, box.bottom, box.right, box.top - line)
    width, height = round(inside.width), round(inside.height)
    if width > 8 and height > 8:
        picture = _picture(shown, place, width, height)
        if picture is None:
            painter.text(inside, tr("The graphics card has no room for this picture"), theme.faint, "CENTER")
        else:
            painter.image(inside, picture)
    above = Box(box.left + 4 * painter.scale, box.top - line, box.right - 4 * painter.scale, box.top)
    painter.text(above, name, theme.text)


def _picture(shown: Shown, place: int, width: int, height: int) -> Any | None:
    """Return the picture of one of the surfaces, drawn again only if something has changed."""
    import numpy as np

    key = (shown.direction, shown.zoom, width, height)
    known = shown.pictures.get(place)
    if known is not None and known[0] == key:
        return known[1]
    assert shown.surfaces is not None
    assert shown.prepared is not None
    both = shown.surfaces.query.vertices, shown.surfaces.match.vertices
    every = np.abs(np.concatenate(both))
    up = shown.surfaces.up_axis
    across = float(np.hypot(every[:, 0], every[:, 3 - up]).max(initial=0))
    scale = pixels_per_unit(shown.direction, across, float(every[:, up].max(initial=0)), width, height)
    rotation = rows(shown.direction, shown.surfaces.up_axis)
    picture = render(shown.prepared[place], rotation, scale * shown.zoom / _MARGIN, width, height)
    shown.pictures[place] = key, picture
    return picture


def _draw_legend(context: Any, painter: Painter, shown: Shown, box: Box, most: float) -> None:
    theme, line = painter.theme, _LINE * painter.scale
    surfaces = shown.surfaces
    assert surfaces is not None
    width = min(box.width, _WIDEST * painter.scale)
    left, bottom = box.left + (box.width - width) / 2, box.bottom + 2 * line
    colors = distance_colors([most * (step + 0.5) / _STEPS for step in range(_STEPS)], most)
    for step, (red, green, blue) in enumerate(colors.tolist()):
        start, end = (left + width * edge / _STEPS for edge in (step, step + 1))
        painter.box(
            Box(round(start), bottom + 3, round(end), bottom + 3 + _BAR * painter.scale),
            (red, green, blue, 1),
        )
    top = Box(left, box.top - line, left + width, box.top)
    painter.text(top, "0", theme.text)
    painter.text(top, length_text(context, most / 2), theme.text, "CENTER")
    painter.text(top, tr("{length} or more").format(length=length_text(context, most)), theme.text, "RIGHT")
    sentence = tr("Distance between the surfaces: median {median}, 95 % within {most}").format(
        median=length_text(context, surfaces.typical), most=length_text(context, surfaces.most)
    )
    painter.text(
        Box(box.left, box.bottom + line, box.right, box.bottom + 2 * line), sentence, theme.text, "CENTER"
    )
    origins = surfaces.query.origin, surfaces.match.origin
    if "preview" in origins:
        source = tr("From the preview in the library, which has about 1,000 faces")
    elif "sample" in origins:
        source = tr("From the sample of points in the library")
    else:
        source = tr("From the meshes themselves")
    painter.text(Box(box.left, box.bottom, box.right, box.bottom + line), source, theme.faint, "CENTER")
