# SPDX-License-Identifier: MIT
"""Small pieces of text that several commands print."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from shapegoogle_core.api.text import counted, display_width, one_line, shortened, visible

__all__ = ["counted", "put", "say", "say_lines", "table"]

# Columns of a cell that is not the last of its row; names of files may have 255 characters.
WIDEST_CELL = 60


def put(text: str) -> None:
    """Print to stdout, at once: where both streams go to one file, nothing may come in between.

    Parameters
    ----------
    text : str
        Names in it may contain anything; line breaks in names must have been escaped.
    """
    print(visible(text), flush=True)


def say(text: str) -> None:
    """Print a sentence to stderr.

    Parameters
    ----------
    text : str
        Line breaks in it are escaped: they are those of a name.
    """
    print(one_line(text), file=sys.stderr, flush=True)


def say_lines(text: str) -> None:
    """Print a text of several lines to stderr, such as a traceback.

    Parameters
    ----------
    text : str
    """
    print(visible(text.rstrip("\n")), file=sys.stderr, flush=True)


def table(rows: Sequence[Sequence[str]], alignment: str) -> list[str]:
    """Align cells in columns.

    Parameters
    ----------
    rows : sequence of sequence of str
        At least one; all of the same length. Cells may contain any name: what would break the table is
        escaped, and long names are cut, except in the last column.
    alignment : str
        For each column "<" (left) or ">" (right).

    Returns
    -------
    lines : list of str
        One for each row, without spaces at the end.
    """
    cells = [
        [*(shortened(one_line(cell), WIDEST_CELL) for cell in row[:-1]), one_line(row[-1])] for row in rows
    ]
    widths = [max(map(display_width, column)) for column in zip(*cells, strict=True)]
    columns = list(zip(alignment, widths, strict=True))
    return [
        "  ".join(
            _padded(cell, side, width) for cell, (side, width) in zip(row, columns, strict=True)
        ).rstrip()
        for row in cells
    ]


def _padded(cell: str, side: str, width: int) -> str:
    space = " " * (width - display_width(cell))
    return space + cell if side == ">" else cell + space
