# SPDX-License-Identifier: MIT
"""Text for people: numbers with nouns, durations, and names that cannot break a line."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator

__all__ = ["counted", "display_width", "duration", "one_line", "shortened", "visible"]

# Control characters, invisible ones such as those that change the direction of writing, lone surrogates of
# undecodable names, and separators of lines and paragraphs.
_ESCAPED = {"Cc", "Cf", "Cs", "Zl", "Zp"}
# Joiners: emoji, Persian and the scripts of India are not written without them.
_JOINERS = "\u200c\u200d"
_ZERO_WIDTH = {"Mn", "Me", "Cf"}


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


def visible(text: str) -> str:
    r"""Escape what a terminal would act upon or hide, but keep line breaks.

    Parameters
    ----------
    text : str

    Returns
    -------
    text : str
        With control characters, escape sequences, marks that change the direction of writing and undecodable
        bytes as Python writes them, such as ``\x1b``.

    Examples
    --------
    >>> from shapegoogle_core.api.text import visible
    >>> print(visible("hor\x1b[31mse.obj"))
    hor\x1b[31mse.obj
    """
    return "\n".join(map(one_line, text.split("\n")))


def one_line(text: str) -> str:
    r"""Escape like `visible`, and line breaks too.

    Parameters
    ----------
    text : str

    Returns
    -------
    text : str

    Examples
    --------
    >>> from shapegoogle_core.api.text import one_line
    >>> print(one_line("two\nlines.obj"))
    two\nlines.obj
    """
    if text.isprintable():
        return text
    return "".join(
        character.encode("unicode_escape").decode("ascii") if _is_escaped(character) else character
        for character in text
    )


def display_width(text: str) -> int:
    """Count the columns that a text takes on a terminal.

    Parameters
    ----------
    text : str
        In one line.

    Returns
    -------
    columns : int
        Two for a character of East Asia or an emoji, none for an accent that is written over the one before.

    Examples
    --------
    >>> from shapegoogle_core.api.text import display_width
    >>> display_width("horse"), display_width("馬")
    (5, 2)
    """
    return sum(map(_width, text))


def shortened(text: str, columns: int) -> str:
    """Cut a text in the middle if it is too wide; its beginning and its end tell most.

    Parameters
    ----------
    text : str
        In one line.
    columns : int
        Largest width on a terminal.

    Returns
    -------
    text : str

    Examples
    --------
    >>> from shapegoogle_core.api.text import shortened
    >>> shortened("a_very_long_name.obj", 12)
    'a_very…e.obj'
    """
    if display_width(text) <= columns:
        return text
    end = "".join(reversed(list(_first(reversed(text), (columns - 1) // 2))))
    return "".join(_first(text, columns - 1 - display_width(end))) + "…" + end


def _first(characters: Iterator[str] | str, columns: int) -> Iterator[str]:
    for character in characters:
        columns -= _width(character)
        if columns < 0:
            return
        yield character


def _is_escaped(character: str) -> bool:
    return unicodedata.category(character) in _ESCAPED and character not in _JOINERS


def _width(character: str) -> int:
    if unicodedata.category(character) in _ZERO_WIDTH:
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1
