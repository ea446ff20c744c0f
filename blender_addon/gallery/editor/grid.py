# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the pictures of the gallery are, and which of them is at a place: arithmetic without Blender.

Lengths are pixels; y grows upwards, as in Blender's regions. `scale` is the scale of the interface.
"""

from __future__ import annotations

from dataclasses import dataclass

from .layout import Box

__all__ = ["Grid"]

# At a scale of 1.
_GAP, _SCROLLBAR, _LINE, _INSET = 8, 10, 18, 4
_BADGE = 34, 18
_LINES = 2
# Side of a picture in an area that is too low for a row.
_SMALLEST = 16
_SHORTEST_HANDLE = 24


@dataclass(frozen=True)
class Grid:
    """Cells of the same size, row by row from the top left.

    Attributes
    ----------
    box : Box
        Where they are.
    count : int
        Number of cells.
    columns : int
    cell_width, cell_height : float
        With the gap to the next cell.
    picture : float
        Width and height of a picture.
    gap, inset, line : float
        Gap between cells, margin inside them, and height of a line of text.
    scale : float
    """

    box: Box
    count: int
    columns: int
    cell_width: float
    cell_height: float
    picture: float
    gap: float
    inset: float
    line: float
    scale: float

    @classmethod
    def of(cls, box: Box, count: int, picture: float, scale: float) -> Grid:
        """Fit as many columns as possible into a box, and spread them evenly over its width.

        Parameters
        ----------
        box : Box
        count : int
        picture : float
            Width of a picture at a scale of 1. A picture is smaller where not even one fits.
        scale : float

        Returns
        -------
        grid : Grid
        """
        room = max(box.width - _SCROLLBAR * scale, box.width / 2, 1.0)
        # In a narrow area gaps shrink too.
        gap, inset, line = min(_GAP * scale, room / 8), min(_INSET * scale, room / 16), _LINE * scale
        texts = _LINES * line
        # A row has to be visible as a whole.
        side = min(picture * scale, room - 2 * inset - gap, box.height - texts - 2 * inset - gap)
        side = max(side, min(_SMALLEST * scale, room - 2 * inset - gap))
        columns = max(1, int(room // (side + 2 * inset + gap)))
        return cls(
            box, count, columns, room / columns, side + texts + 2 * inset + gap, side, gap, inset, line, scale
        )

    @property
    def rows(self) -> int:
        """Number of rows."""
        return -(-self.count // self.columns)

    @property
    def largest_scroll(self) -> float:
        """How far it can be scrolled."""
        return max(0.0, self.rows * self.cell_height + self.gap - self.box.height)

    def clamped(self, scroll: float) -> float:
        """Return the nearest scroll that is possible."""
        return min(max(scroll, 0.0), self.largest_scroll)

    def cell(self, index: int, scroll: float) -> Box:
        """Return the box of a cell, without the gap.

        Parameters
        ----------
        index : int
        scroll : float
            How far the grid is scrolled.

        Returns
        -------
        box : Box
            It may be outside that of the grid.
        """
        row, column = divmod(index, self.columns)
        left = self.box.left + column * self.cell_width + self.gap / 2
        top = self.box.top - row * self.cell_height - self.gap + scroll
        return Box(left, top - self.cell_height + self.gap, left + self.cell_width - self.gap, top)

    def picture_in(self, cell: Box) -> Box:
        """Return where in a cell its picture is."""
        left = (cell.left + cell.right - self.picture) / 2
        top = cell.top - self.inset
        return Box(left, top - self.picture, left + self.picture, top)

    def badge_in(self, cell: Box) -> Box:
        """Return where in a cell the number of versions is: the top right corner of its picture."""
        picture = self.picture_in(cell)
        width, height = (length * self.scale for length in _BADGE)
        return Box(picture.right - width, picture.top - height, picture.right, picture.top)

    def lines_in(self, cell: Box) -> list[Box]:
        """Return where in a cell its lines of text are, from the top."""
        top, left, right = self.picture_in(cell).bottom, cell.left + self.inset, cell.right - self.inset
        return [Box(left, top - (row + 1) * self.line, right, top - row * self.line) for row in range(_LINES)]

    def at(self, x: float, y: float, scroll: float) -> int | None:
        """Return the index of the cell at a place.

        Parameters
        ----------
        x, y : float
        scroll : float

        Returns
        -------
        index : int or None
        """
        if not self.box.holds(x, y):
            return None
        column = int((x - self.box.left) // self.cell_width)
        row = int((self.box.top - y + scroll) // self.cell_height)
        for index in (row * self.columns + column, (row - 1) * self.columns + column):
            there = 0 <= column < self.columns and 0 <= index < self.count
            if there and self.cell(index, scroll).holds(x, y):
                return index
        return None

    def visible(self, scroll: float) -> range:
        """Return the indices of the cells that can be seen, in whole or in part."""
        first = int((scroll - self.gap) // self.cell_height)
        last = int((scroll + self.box.height) // self.cell_height)
        return range(max(first, 0) * self.columns, min((last + 1) * self.columns, self.count))

    def shown(self, index: int, scroll: float) -> float:
        """Return the nearest scroll at which a cell can be seen as a whole."""
        top = index // self.columns * self.cell_height
        return self.clamped(min(max(scroll, top + self.cell_height + self.gap - self.box.height), top))

    def step(self, index: int, key: str) -> int:
        """Return the cell that a key leads to.

        Parameters
        ----------
        index : int
            Of the chosen cell; −1 for none.
        key : str
            Blender's name of the key.

        Returns
        -------
        index : int
            −1 if there are no cells.
        """
        page = max(1, int(self.box.height // self.cell_height)) * self.columns
        steps = {
            "LEFT_ARROW": -1,
            "RIGHT_ARROW": 1,
            "UP_ARROW": -self.columns,
            "DOWN_ARROW": self.columns,
            "PAGE_UP": -page,
            "PAGE_DOWN": page,
        }
        if not self.count:
            return -1
        if key in ("HOME", "END"):
            return 0 if key == "HOME" else self.count - 1
        if index < 0:
            return 0
        target = index + steps[key]
        if 0 <= target < self.count:
            return target
        # Beyond the ends: the last row may be shorter, else stay where it is.
        if key in ("DOWN_ARROW", "PAGE_DOWN") and index // self.columns < self.rows - 1:
            return self.count - 1
        if key == "PAGE_UP":
            return index % self.columns
        return min(index, self.count - 1)

    @property
    def bar(self) -> Box:
        """Where the scroll bar is."""
        width = _SCROLLBAR * self.scale
        return Box(self.box.right - width, self.box.bottom, self.box.right, self.box.top)

    def handle(self, scroll: float) -> Box | None:
        """Return the handle of the scroll bar; None if all can be seen."""
        if not self.largest_scroll:
            return None
        bar = self.bar.shrunk(2 * self.scale)
        whole = self.largest_scroll + self.box.height
        height = min(max(bar.height * self.box.height / whole, _SHORTEST_HANDLE * self.scale), bar.height)
        top = bar.top - (bar.height - height) * self.clamped(scroll) / self.largest_scroll
        return Box(bar.left, top - height, bar.right, top)

    def dragged(self, scroll: float, distance: float) -> float:
        """Return the scroll after its handle was moved downwards by a distance."""
        handle = self.handle(scroll)
        bar = self.bar.shrunk(2 * self.scale)
        if handle is None or bar.height <= handle.height:
            return self.clamped(scroll)
        return self.clamped(scroll + distance * self.largest_scroll / (bar.height - handle.height))
