# SPDX-License-Identifier: MIT
"""Types of option values, filters, and the options that several commands share."""

from __future__ import annotations

import argparse
from collections.abc import Callable

from shapegoogle_core.library.evidence import KINDS
from shapegoogle_core.library.filter import Filter

__all__ = [
    "add_filters",
    "add_inputs",
    "add_jobs",
    "add_library",
    "filter_of",
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


def add_filters(parser: argparse.ArgumentParser) -> None:
    """Add the options of a `Filter` to a command.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    group = parser.add_argument_group("filters", "Only matches that meet all of these conditions:")
    group.add_argument(
        "--name",
        type=_text,
        metavar="TEXT",
        help="the name contains this text, ignoring case; * and ? are wildcards for whole names",
    )
    group.add_argument(
        "--folder", type=_text, metavar="FOLDER", help="the file is in this folder or below it"
    )
    group.add_argument("--tag", type=_text, metavar="TAG", help="the shape has this tag")
    group.add_argument(
        "--faces",
        type=_range,
        metavar="LO:HI",
        help="number of faces; one of the limits may be left out: 1000:",
    )
    group.add_argument(
        "--size", type=_range, metavar="LO:HI", help="largest extent, in units of the file; such as :2.5"
    )
    group.add_argument("--kind", choices=KINDS, help="kind of the evidence")
    group.add_argument("--min-similarity", type=share, metavar="S", help="least similarity, 0 to 1")


def filter_of(options: argparse.Namespace) -> Filter | None:
    """Return the filter that options ask for.

    Parameters
    ----------
    options : argparse.Namespace
        With the options of `add_filters`.

    Returns
    -------
    where : Filter or None
        None without conditions.
    """
    where = Filter(
        name=options.name,
        folder=options.folder,
        tag=options.tag,
        faces=options.faces,
        size=options.size,
        kind=options.kind,
        min_similarity=options.min_similarity,
    )
    return None if where == Filter() else where


def _text(text: str) -> str:
    if not text.strip():
        raise argparse.ArgumentTypeError("must not be empty")
    return text


def _range(text: str) -> tuple[float | None, float | None]:
    """Parse LO:HI, LO: or :HI."""
    low, colon, high = text.partition(":")
    try:
        limits = float(low) if low else None, float(high) if high else None
        Filter(size=limits)
    except ValueError:
        limits = None, None
    if not colon or limits == (None, None):
        raise argparse.ArgumentTypeError(
            f"must be a range LO:HI of numbers from 0 on, such as 1000:5000, 1000: or :5000, not {text!r}"
        )
    return limits
