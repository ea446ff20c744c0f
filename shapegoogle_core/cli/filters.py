# SPDX-License-Identifier: MIT
"""Options of the command line that filter matches."""

from __future__ import annotations

import argparse

from shapegoogle_core.cli.arguments import share
from shapegoogle_core.library.evidence import KINDS
from shapegoogle_core.library.filter import Filter

__all__ = ["add_filters", "filter_of"]


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
