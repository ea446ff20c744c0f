# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawing in a region: boxes, texts and pictures in the colours of the theme."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import blf
import gpu
from gpu_extras.batch import batch_for_shader

from .layout import Box, shortened

__all__ = ["Color", "Painter", "Theme"]

Color = tuple[float, float, float, float]

_FONT = 0


@dataclass(frozen=True)
class Theme:
    """Colours of the interface.

    Attributes
    ----------
    background, text, faint : tuple of float
        Of the area, its text, and less important text.
    field, field_text : tuple of float
        Of text fields.
    button : tuple of float
    cell, chosen, chosen_text : tuple of float
        Of what lies below a picture, and of the chosen one.
    """

    background: Color
    text: Color
    faint: Color
    field: Color
    field_text: Color
    button: Color
    cell: Color
    chosen: Color
    chosen_text: Color

    @classmethod
    def of(cls, context: Any) -> Theme:
        """Read the colours of the theme in use."""
        theme = context.preferences.themes[0]
        colors = theme.user_interface
        text = _color(colors.wcol_regular.text)
        return cls(
            background=_color(theme.file_browser.space.back),
            text=text,
            faint=(*text[:3], 0.65),
            field=_color(colors.wcol_text.inner),
            field_text=_color(colors.wcol_text.text),
            button=_color(colors.wcol_tool.inner),
            cell=_color(colors.wcol_box.inner),
            chosen=_color(colors.wcol_toggle.inner_sel),
            chosen_text=_color(colors.wcol_toggle.text_sel),
        )


def _color(values: Sequence[float]) -> Color:
    red, green, blue, *alpha = values
    return red, green, blue, alpha[0] if alpha else 1.0


class Painter:
    """Draws in the region that is being drawn.

    Parameters
    ----------
    context : bpy.types.Context
    """

    def __init__(self, context: Any) -> None:
        self.theme = Theme.of(context)
        self.scale: float = context.preferences.system.ui_scale
        self._points = context.preferences.ui_styles[0].widget.points * self.scale
        self._flat = gpu.shader.from_builtin("UNIFORM_COLOR")
        self._image = gpu.shader.from_builtin("IMAGE_COLOR")

    def box(self, box: Box, color: Color) -> None:
        """Fill a box."""
        if not box.width or not box.height:
            return
        gpu.state.blend_set("ALPHA")
        batch = batch_for_shader(self._flat, "TRI_FAN", {"pos": _corners(box)})
        self._flat.uniform_float("color", color)
        batch.draw(self._flat)

    def frame(self, box: Box, color: Color, width: float = 1) -> None:
        """Draw the border of a box, inside it."""
        for side in (
            Box(box.left, box.bottom, box.left + width, box.top),
            Box(box.right - width, box.bottom, box.right, box.top),
            Box(box.left, box.bottom, box.right, box.bottom + width),
            Box(box.left, box.top - width, box.right, box.top),
        ):
            self.box(side, color)

    def image(self, box: Box, texture: Any, strength: float = 1.0) -> None:
        """Draw a picture whose transparent pixels are black."""
        gpu.state.blend_set("ALPHA_PREMULT")
        corners = {"pos": _corners(box), "texCoord": ((0, 0), (1, 0), (1, 1), (0, 1))}
        batch = batch_for_shader(self._image, "TRI_FAN", corners)
        self._image.bind()
        self._image.uniform_sampler("image", texture)
        self._image.uniform_float("color", (strength, strength, strength, strength))
        batch.draw(self._image)

    def width_of(self, text: str) -> float:
        """Return the width of a text."""
        blf.size(_FONT, self._points)
        return float(blf.dimensions(_FONT, text)[0])

    def text(self, box: Box, text: str, color: Color, align: str = "LEFT") -> None:
        """Write a text in the middle of the height of a box, shortened to its width.

        Parameters
        ----------
        box : Box
        text : str
        color : tuple of float
        align : {"LEFT", "CENTER", "RIGHT"}
        """
        shown = shortened(text, box.width, self.width_of)
        if not shown:
            return
        free = box.width - self.width_of(shown)
        left = box.left + {"LEFT": 0, "CENTER": free / 2, "RIGHT": free}[align]
        # The same for all texts, whatever letters reach below the line.
        height = blf.dimensions(_FONT, "x")[1]
        blf.position(_FONT, round(left), round((box.bottom + box.top - height) / 2), 0)
        blf.color(_FONT, *color)
        gpu.state.blend_set("ALPHA")
        blf.draw(_FONT, shown)


def _corners(box: Box) -> tuple[tuple[float, float], ...]:
    return (
        (box.left, box.bottom),
        (box.right, box.bottom),
        (box.right, box.top),
        (box.left, box.top),
    )
