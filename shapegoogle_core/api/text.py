# SPDX-License-Identifier: MIT
"""Small pieces of text for people: numbers with nouns, durations."""

from __future__ import annotations

__all__ = ["counted", "duration"]


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


def duration(seconds: float) -> str:
    """Write a duration, rounded.

    Parameters
    ----------
    seconds : float

    Returns
    -------
    text : str
        Such as "3 min".
    """
    if seconds < 59.5:
        return f"{max(round(seconds), 1)} s"
    if seconds < 3570:
        return f"{round(seconds / 60)} min"
    return f"{seconds / 3600:.1f} h"
