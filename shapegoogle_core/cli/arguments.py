# SPDX-License-Identifier: MIT
"""Types of option values, filters, and the options that several commands share."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

from shapegoogle_core.api.arguments import as_path
from shapegoogle_core.library.evidence import KINDS
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.origin import SHAPE_TYPES
from shapegoogle_core.library.storage.address import as_place

if TYPE_CHECKING:
    from shapegoogle_core.indexing.shards import Shard
    from shapegoogle_core.library.searchable import SearchableLibrary

__all__ = [
    "SEARCHED",
    "add_filters",
    "add_flag",
    "add_inputs",
    "add_jobs",
    "add_library",
    "add_roots",
    "add_value",
    "filter_of",
    "map_roots",
    "named_folder",
    "number_from",
    "numbers",
    "positive_number",
    "positive_share",
    "shard_from",
    "share",
]

SEARCHED = "library file, postgresql:// address, or https:// address of a service"
"""Help of the option ``--library`` of commands that search."""


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


def numbers(text: str) -> str:
    """Check a list of whole numbers.

    Parameters
    ----------
    text : str
        Such as "1, 10,20"; numbers may be negative. Empty for none.

    Returns
    -------
    numbers : str
        In ascending order, each once, separated by commas alone.

    Raises
    ------
    argparse.ArgumentTypeError
        For any other text.

    Examples
    --------
    >>> from shapegoogle_core.cli.arguments import numbers
    >>> numbers("20, 1,10")
    '1,10,20'
    """
    try:
        listed = sorted({int(number) for number in text.split(",")}) if text else []
    except ValueError:
        message = f"must be whole numbers separated by commas, such as 1,10,20, not {text!r}"
        raise argparse.ArgumentTypeError(message) from None
    return ",".join(map(str, listed))


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
    return _number(text, "a number above 0", lambda number: 0 < number < math.inf)


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
    return _number(text, "a number from 0 to 1", lambda number: 0 <= number <= 1)


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
    return _number(text, "a number above 0 and at most 1", lambda number: 0 < number <= 1)


def add_value(
    parser: argparse.ArgumentParser | argparse._ArgumentGroup,
    option: str,
    metavar: str,
    summary: str,
    convert: Callable[[str], object] = str,
    default: object = None,
) -> None:
    """Add an option with one value.

    Parameters
    ----------
    parser : argparse.ArgumentParser, or a group of it
    option : str
        As typed: "--top".
    metavar : str
        Placeholder of the value in the help.
    summary : str
        Help text; ``%(default)s`` stands for the default value.
    convert : callable, optional
        Turns the text of the value into the value, see `number_from`.
    default : object, optional
        Value of the option if it is left out.
    """
    parser.add_argument(option, type=convert, default=default, metavar=metavar, help=summary)


def add_flag(parser: argparse.ArgumentParser, option: str, summary: str) -> None:
    """Add an option without a value, off by default.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    option : str
        As typed: "--json".
    summary : str
        Help text.
    """
    parser.add_argument(option, action="store_true", help=summary)


def add_library(
    parser: argparse.ArgumentParser | argparse._MutuallyExclusiveGroup,
    summary: str = "library file, or postgresql:// address",
    *,
    required: bool = True,
) -> None:
    """Add the option ``--library``.

    Parameters
    ----------
    parser : argparse.ArgumentParser, or a group of it
    summary : str, optional
        Help text.
    required : bool, optional
        Whether the option must be given.
    """
    parser.add_argument("--library", type=as_place, required=required, metavar="FILE", help=summary)


def add_inputs(parser: argparse.ArgumentParser, least: int = 1) -> None:
    """Add the positional arguments for folders and mesh files.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    least : int, optional
        0 for a command that can do without, otherwise 1.
    """
    parser.add_argument(
        "inputs",
        type=as_path,
        nargs="+" if least else "*",
        metavar="FOLDER",
        help="folder, searched recursively, or file of a mesh or scan",
    )


def add_roots(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--root`` of commands that only read.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    root = "the root NAME of the library is FOLDER on this computer; may be repeated"
    parser.add_argument(
        "--root", action="append", default=[], type=named_folder, metavar="NAME=FOLDER", help=root
    )


def map_roots(library: SearchableLibrary, options: argparse.Namespace) -> None:
    """Apply the option ``--root`` to an open library.

    Parameters
    ----------
    library : SearchableLibrary
    options : argparse.Namespace

    Raises
    ------
    LibraryError
        If the library has no such root.
    """
    for name, folder in options.root:
        library.map_root(name, folder)


def named_folder(text: str) -> tuple[str, Path]:
    """Parse NAME=FOLDER.

    Parameters
    ----------
    text : str

    Returns
    -------
    name, folder : str, Path

    Raises
    ------
    argparse.ArgumentTypeError
        If one of them is missing, or the folder is not there.
    """
    name, equals, folder = text.partition("=")
    path = as_path(folder)
    if not (equals and name.strip() and folder.strip()):
        raise argparse.ArgumentTypeError(f"must be NAME=FOLDER, such as assets=~/models, not {text!r}")
    if not path.is_dir():
        raise argparse.ArgumentTypeError(f"there is no folder {str(path)!r}")
    return name.strip(), path


def shard_from(text: str) -> Shard:
    """Parse I/N.

    Parameters
    ----------
    text : str

    Returns
    -------
    shard : Shard

    Raises
    ------
    argparse.ArgumentTypeError
        If there is no such part.
    """
    from shapegoogle_core.indexing.shards import Shard

    number, slash, count = text.partition("/")
    if slash and number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count):
        return Shard(int(number), int(count))
    raise argparse.ArgumentTypeError(f"must be I/N with I from 1 to N, such as 2/8, not {text!r}")


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--jobs``.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    add_value(parser, "--jobs", "N", "worker processes (default: one per processor)", number_from(1))


def _number(text: str, wanted: str, accepts: Callable[[float], bool]) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not accepts(number):
        raise argparse.ArgumentTypeError(f"must be {wanted}, not {text!r}")
    return number


def add_filters(parser: argparse.ArgumentParser) -> None:
    """Add the options of a `Filter` to a command.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    """
    group = parser.add_argument_group("filters", "Only matches that meet all of these conditions:")
    name = "the name contains this text, ignoring case; * and ? are wildcards for whole names"
    add_value(group, "--name", "TEXT", name, _text)
    add_value(group, "--folder", "FOLDER", "the file is in this folder or below it", _text)
    add_value(group, "--tag", "TAG", "the shape has this tag", _text)
    catalog = "the shape is in this asset catalog or below it, such as Props/Chairs"
    add_value(group, "--catalog", "CATALOG", catalog, _text)
    group.add_argument(
        "--shape-type", choices=SHAPE_TYPES, help="what the shape is in its file, such as collection or text"
    )
    add_value(group, "--file-type", "TYPE", "the file's name has this ending, such as blend or stl", _text)
    faces = "number of faces; one of the limits may be left out: 1000:"
    add_value(group, "--faces", "LO:HI", faces, _range)
    add_value(group, "--size", "LO:HI", "largest extent, in units of the file; such as :2.5", _range)
    group.add_argument("--kind", choices=KINDS, help="kind of the evidence")
    add_value(group, "--min-similarity", "S", "least similarity, 0 to 1", share)


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
    # Not every condition is an option of the command line.
    where = Filter(**{field.name: getattr(options, field.name, None) for field in fields(Filter)})
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
