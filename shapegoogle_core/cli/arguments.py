# SPDX-License-Identifier: MIT
"""What all commands share: exit codes, kinds of numbers on the command line, words on stderr."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable

__all__ = ["DONE", "INTERRUPTED", "SOME_FAILED", "UNUSABLE", "number_from", "positive_number", "say", "share"]

DONE = 0
SOME_FAILED = 1
"""Some inputs failed, each named on stderr; the others are done."""
UNUSABLE = 2
"""Nothing can be done: wrong usage, or a library, model or file that cannot be opened or written."""
INTERRUPTED = 130
"""By Ctrl-C (SIGINT) or by whoever ended the process in an orderly way (SIGTERM)."""


def number_from(least: int) -> Callable[[str], int]:
    """Make a type for `argparse`: whole numbers from this one.

    Parameters
    ----------
    least : int

    Returns
    -------
    parse : callable
        Turns the text of an option into the number; raises `argparse.ArgumentTypeError` if it is none.
    """

    def parse(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"must be a whole number from {least}, not {text!r}")
        return int(text)

    return parse


def positive_number(text: str) -> float:
    """Turn the text of an option into a finite number above 0.

    Raises
    ------
    argparse.ArgumentTypeError
        If it is none.
    """
    number = _number(text)
    if not 0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a number above 0, not {text!r}")
    return number


def share(text: str) -> float:
    """Turn the text of an option into a number from 0 to 1.

    Raises
    ------
    argparse.ArgumentTypeError
        If it is none.
    """
    number = _number(text)
    if not 0 <= number <= 1:
        raise argparse.ArgumentTypeError(f"must be a number from 0 to 1, not {text!r}")
    return number


def say(text: str) -> None:
    """Print to stderr."""
    print(text, file=sys.stderr, flush=True)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return -1.0
