# SPDX-License-Identifier: MIT
"""Small pieces of text that several commands print."""

from __future__ import annotations

import sys
from collections.abc import Sequence

__all__ = ["counted", "say", "table"]


def say(text: str) -> None:
    """Print to stderr.

    Parameters
    ----------
    text : str
    """
    print(text, file=sys.stderr, flush=True)


def counted(number: int, noun: str) -> str:
    """Write a number with its noun, such as "1 file" or "2,000 files".

    Parameters
    ----------
    number : int
    noun : str
        In the singular.

    Returns
    -------
    text : str
    """
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def table(rows: Sequence[Sequence[str]], alignment: str) -> list[str]:
    """Align cells in columns.

    Parameters
    ----------
    rows : sequence of sequence of str
        At least one; all of the same length.
    alignment : str
        For each column "<" (left) or ">" (right).

    Returns
    -------
    lines : list of str
        One for each row, without spaces at the end.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    columns = list(zip(alignment, widths, strict=True))
    return [
        "  ".join(f"{cell:{side}{width}}" for cell, (side, width) in zip(row, columns, strict=True)).rstrip()
        for row in rows
    ]
