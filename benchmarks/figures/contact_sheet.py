# SPDX-License-Identifier: MIT
"""Contact sheets: several pictures with captions in one."""

from __future__ import annotations

from collections.abc import Sequence

from PIL import Image, ImageDraw, ImageFont

__all__ = ["contact_sheet"]

_PAPER, _INK, _FRAME = (255, 255, 255), (40, 44, 52), (222, 226, 232)
_GAP = 14
_TEXT_SIZE, _TITLE_SIZE = 14, 20
_LINE = 1.3

Font = ImageFont.FreeTypeFont | ImageFont.ImageFont


def contact_sheet(
    images: Sequence[Image.Image], captions: Sequence[str], columns: int = 5, title: str = ""
) -> Image.Image:
    """Arrange pictures in rows, each above its caption.

    Parameters
    ----------
    images : sequence of PIL.Image.Image
        Of any sizes and modes. Cells are as large as the largest image.
    captions : sequence of str
        One per image. Line breaks are kept, and long lines wrap.
    columns : int, optional
        Maximum number of columns.
    title : str, optional
        Heading above all pictures.

    Returns
    -------
    sheet : PIL.Image.Image
        "RGB".

    Raises
    ------
    ValueError
        If there are no images, not one caption per image, or no columns.

    Examples
    --------
    >>> from PIL import Image
    >>> from benchmarks.figures.contact_sheet import contact_sheet
    >>> contact_sheet([Image.new("RGB", (50, 40))] * 3, ["one", "two", "three"], columns=2).size
    (142, 172)
    """
    if not images:
        raise ValueError("a contact sheet needs at least one image")
    if len(images) != len(captions):
        raise ValueError(f"{len(images)} images need as many captions, not {len(captions)}")
    if columns < 1:
        raise ValueError(f"a contact sheet needs at least one column, not {columns}")
    columns = min(columns, len(images))
    text_font, title_font = ImageFont.load_default(_TEXT_SIZE), ImageFont.load_default(_TITLE_SIZE)
    cell_width = max(image.width for image in images)
    cell_height = max(image.height for image in images)
    width = columns * (cell_width + _GAP) + _GAP

    title_lines = _wrap(title, title_font, width - 2 * _GAP) if title else []
    texts = [_wrap(caption, text_font, cell_width) for caption in captions]
    rows = [range(start, min(start + columns, len(images))) for start in range(0, len(images), columns)]
    text_line, title_line = round(_TEXT_SIZE * _LINE), round(_TITLE_SIZE * _LINE)
    heights = [
        cell_height + _GAP // 2 + text_line * max(len(texts[index]) for index in row) + _GAP for row in rows
    ]
    top = _GAP + (len(title_lines) * title_line + _GAP // 2 if title_lines else 0)

    sheet = Image.new("RGB", (width, top + sum(heights)), _PAPER)
    draw = ImageDraw.Draw(sheet)
    for number, line in enumerate(title_lines):
        draw.text((_GAP, _GAP + number * title_line), line, _INK, title_font)
    for row, height in zip(rows, heights, strict=True):
        for column, index in enumerate(row):
            left = _GAP + column * (cell_width + _GAP)
            image = images[index].convert("RGBA")
            place = left + (cell_width - image.width) // 2, top + (cell_height - image.height) // 2
            sheet.paste(image, place, image)
            draw.rectangle((left, top, left + cell_width - 1, top + cell_height - 1), outline=_FRAME)
            for number, line in enumerate(texts[index]):
                draw.text((left, top + cell_height + _GAP // 2 + number * text_line), line, _INK, text_font)
        top += height
    return sheet


def _wrap(text: str, font: Font, width: int) -> list[str]:
    """Split a text into lines no wider than `width` pixels, and words that are too long for a line."""
    lines = []
    for paragraph in text.splitlines():
        line = ""
        for word in paragraph.split():
            longer = f"{line} {word}" if line else word
            if font.getlength(longer) <= width:
                line = longer
                continue
            if line:
                lines.append(line)
            while font.getlength(word) > width and len(word) > 1:
                fits = next(
                    n for n in range(len(word) - 1, 0, -1) if n == 1 or font.getlength(word[:n]) <= width
                )
                lines.append(word[:fits])
                word = word[fits:]
            line = word
        lines.append(line)
    return lines
