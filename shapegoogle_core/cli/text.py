# SPDX-License-Identifier: MIT
"""Small pieces of text that several commands print."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from shapegoogle_core.api.text import counted

__all__ = ["counted", "put", "say", "table"]


def put(text: str) -> None:
    """Print to stdout, at once: where both streams go to one file, nothing may come in between.

    Parameters
    ----------
    text : str
    """
    print(text, flush=True)


def say(text: str) -> None:
    """Print to stderr.

    Parameters
    ----------
    text : str
    """
    print(text, file=sys.stderr, flush=True)


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
