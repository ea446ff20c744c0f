# SPDX-License-Identifier: MIT
"""Types of option values, and the options that several commands share."""

from __future__ import annotations

import argparse
from collections.abc import Callable

__all__ = [
    "add_inputs",
    "add_jobs",
    "add_library",
    "number_from",
    "positive_number",
    "positive_share",
    "share",
]


def number_from(least: int) -> Callable[[str], int]:
    """Make an `argparse` type for whole numbers of at least `least`.

    Parameters
    ----------
    least : int

    Returns
    -------
    parse : callable
        Turns the text of an option into the number; raises `argparse.ArgumentTypeError` for other texts.
    """

    def parse(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"must be a whole number of at least {least}, not {text!r}")
        return int(text)

    return parse


def positive_number(text: str) -> float:
    """Parse a finite number above 0.

    Parameters
    ----------
    text : str

    Returns
    -------
    number : float

    Raises
    ------
    argparse.ArgumentTypeError
        For any other text.
    """
    number = _number(text)
    if not 0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a number above 0, not {text!r}")
    return number


def share(text: str) -> float:
    """Parse a number from 0 to 1.

    Parameters
    ----------
    text : str

    Returns
    -------
    number : float

    Raises
    ------
    argparse.ArgumentTypeError
        For any other text.
    """
    number = _number(text)
    if not 0 <= number <= 1:
        raise argparse.ArgumentTypeError(f"must be a number from 0 to 1, not {text!r}")
    return number


def positive_share(text: str) -> float:
    """Parse a number above 0 and at most 1.

    Parameters
    ----------
    text : str

    Returns
    -------
    number : float

    Raises
    ------
    argparse.ArgumentTypeError
        For any other text.
    """
    number = _number(text)
    if not 0 < number <= 1:
        raise argparse.ArgumentTypeError(f"must be a number above 0 and at most 1, not {text!r}")
    return number


def add_library(parser: argparse.ArgumentParser, summary: str = "library file") -> None:
    """Add the required option ``--library``.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    summary : str, optional
        Help text.
    """
    parser.add_argument("--library", required=True, metavar="FILE", help=summary)


def add_inputs(parser: argparse.ArgumentParser) -> None:
    """Add the positional arguments for folders and mesh files.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "inputs", nargs="+", metavar="FOLDER", help="folder, searched recursively, or file of a mesh or scan"
    )


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--jobs``.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    parser.add_argument(
        "--jobs",
        type=number_from(1),
        metavar="N",
        help="worker processes (default: one per processor)",
    )


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")
