# SPDX-License-Identifier: GPL-3.0-or-later
"""The bag of a shape as a small bar chart (paper, figure 7), for the sidebar."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
import bpy.utils.previews

from .. import state

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from PIL import Image

__all__ = ["clear", "draw_chart", "icon_of", "show"]

SIZE = 256
MOST_CHARTS = 64
_MARGIN, _BASE, _TOP, _TEXT = 10, 30, 12, 20
_PAPER, _INK, _LINE = (38, 38, 38), (230, 230, 230), (96, 96, 96)


def draw_chart(bag: NDArray[np.float64]) -> Image.Image:
    """Draw a bag: one bar for each word, in the colour that the word has on shapes.

    Parameters
    ----------
    bag : (V,) array
        Share of each word, ≥ 0.

    Returns
    -------
    image : PIL.Image.Image
        Square, "RGBA".
    """
    import numpy as np
    from PIL import Image, ImageDraw, ImageFont

    from shapegoogle_core.rendering import word_palette

    image = Image.new("RGBA", (SIZE, SIZE), (*_PAPER, 255))
    draw = ImageDraw.Draw(image)
    left, right, bottom = _MARGIN, SIZE - _MARGIN, SIZE - _BASE
    step = (right - left) / len(bag)
    gap = 1 if step >= 4 else 0
    tallest = max(float(bag.max()), np.finfo(float).tiny)
    for word, (share, color) in enumerate(zip(bag, word_palette(len(bag)), strict=True)):
        height = (bottom - _TOP - _TEXT) * float(share) / tallest
        x = left + word * step
        box = (round(x), round(bottom - height), max(round(x + step) - 1 - gap, round(x)), bottom)
        if height >= 0.5:
            draw.rectangle(box, fill=tuple(np.round(255 * color).astype(int).tolist()))
    draw.line((left, bottom + 1, right, bottom + 1), fill=_LINE)
    font = ImageFont.load_default(_TEXT)
    draw.text((left, SIZE - _BASE + 3), "0", fill=_INK, font=font)
    draw.text((right, SIZE - _BASE + 3), str(len(bag) - 1), fill=_INK, font=font, anchor="ra")
    draw.text((SIZE // 2, SIZE - _BASE + 3), "word", fill=_INK, font=font, anchor="ma")
    draw.text((left, 4), f"{100 * tallest:.0f} %", fill=_INK, font=font)
    return image


def show(item: Any, bag: NDArray[np.float64]) -> None:
    """Make the chart that the sidebar shows of an object.

    Parameters
    ----------
    item : bpy.types.Object
    bag : (V,) array
    """
    import numpy as np

    signature = state.current().signature
    if signature.charts is None:
        signature.charts = bpy.utils.previews.new()
    charts, charted, name = signature.charts, signature.charted, str(item.session_uid)
    preview = charts.get(name) or charts.new(name)
    # Blender counts rows from below.
    pixels = np.asarray(draw_chart(bag), np.float32)[::-1] / 255
    preview.image_size = SIZE, SIZE
    preview.image_pixels_float.foreach_set(pixels.ravel())
    charted[item.session_uid] = name
    charted.move_to_end(item.session_uid)
    while len(charted) > MOST_CHARTS:
        del charts[charted.popitem(last=False)[1]]


def icon_of(item: Any) -> int:
    """Return the number of the icon with an object's chart; 0 if there is none."""
    signature = state.current().signature
    name = signature.charted.get(item.session_uid)
    return 0 if name is None else int(signature.charts[name].icon_id)


def clear() -> None:
    """Remove all charts."""
    signature = state.current().signature
    signature.charted.clear()
    if signature.charts is not None:
        bpy.utils.previews.remove(signature.charts)
        signature.charts = None
