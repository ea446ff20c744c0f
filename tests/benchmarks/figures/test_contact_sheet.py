# SPDX-License-Identifier: MIT
"""Contact sheets: pictures in a grid, and captions that are never cut off."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image, ImageChops, ImageFont

from benchmarks.figures.contact_sheet import contact_sheet


class TestContactSheet:
    tile = Image.new("RGB", (90, 70), (200, 30, 30))

    def test_grid(self) -> None:
        sheet = contact_sheet([self.tile] * 5, ["one", "two", "three", "four", "five"], columns=3)
        red = np.asarray(sheet)[:, :, 0] - np.asarray(sheet)[:, :, 1].astype(int) > 150
        assert red.sum() == pytest.approx(5 * 90 * 70, rel=0.06)
        assert sheet.width < 3 * 90 + 4 * 20

    def test_long_captions_wrap_and_nothing_is_cut_off(self) -> None:
        caption = "a caption of many words, " * 8 + "and_one_long_name_without_any_space_" * 6 + "END"
        one = contact_sheet([self.tile], ["short"])
        tall = contact_sheet([self.tile], [caption], title="a title that is wider than the sheet itself")
        assert tall.width == one.width
        lines = ImageFont.load_default(14).getlength(caption) / 90
        assert tall.height - one.height > 14 * lines
        # Paper stays paper along the whole border.
        border = tall.copy()
        border.paste((255, 255, 255), (6, 6, tall.width - 6, tall.height - 3))
        assert ImageChops.invert(border).getbbox() is None

    def test_transparent_and_smaller_images(self) -> None:
        small = Image.new("RGBA", (20, 20), (0, 0, 255, 0))
        sheet = contact_sheet([self.tile, small], ["", ""], columns=2)
        assert not (np.asarray(sheet)[:, :, 2].astype(int) - np.asarray(sheet)[:, :, 0] > 100).any()

    def test_line_breaks_are_kept(self) -> None:
        one, two = contact_sheet([self.tile], ["a"]), contact_sheet([self.tile], ["a\nb"])
        assert two.height > one.height

    def test_wrong_input(self) -> None:
        with pytest.raises(ValueError, match="at least one image"):
            contact_sheet([], [])
        with pytest.raises(ValueError, match="2 images need as many captions, not 1"):
            contact_sheet([self.tile] * 2, ["a"])
        with pytest.raises(ValueError, match="at least one column"):
            contact_sheet([self.tile], ["a"], columns=0)
