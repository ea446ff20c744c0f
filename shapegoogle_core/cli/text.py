# SPDX-License-Identifier: MIT
"""Small pieces of text that several commands print."""

from __future__ import annotations

import sys

__all__ = ["counted", "say"]


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
