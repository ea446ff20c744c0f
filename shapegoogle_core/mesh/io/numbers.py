# SPDX-License-Identifier: MIT
"""Tables of numbers and polygons in text files, parsed many lines at a time."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import FormatError
from shapegoogle_core.mesh.io.text import Lines
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = [
    "A_POLYGON",
    "DECIMAL_COMMA",
    "NUMBER",
    "check_thousands",
    "parse_corners",
    "parse_numbers",
    "parse_polygons",
    "word_numbers",
]

NUMBER = re.compile(rb"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|nan|inf(?:inity)?)", re.IGNORECASE)
"""A number as text formats write it."""

A_POLYGON = "a polygon (the number of its corners, then as many vertices, counted from 0)"
"""Content of a line of faces, for errors."""

DECIMAL_COMMA = re.compile(rb"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
"""A number with a decimal comma."""

_THOUSANDS = re.compile(rb"[-+]?[1-9]\d{0,2}(?:,\d{3})+")
_FORTRAN_EXPONENT = re.compile(rb"(?<=[\d.])[dD](?=[-+]?\d)")


def parse_numbers(lines: Lines, columns: Sequence[int], expected: str) -> FloatArray:
    """Parse some columns of lines of numbers with blanks between them.

    Decimal commas and the exponents of Fortran (1.5D+00) are read too.

    Parameters
    ----------
    lines : Lines
        Lines may have more columns, and not all the same number of them.
    columns : sequence of int
        Columns to parse, counted from 0.
    expected : str
        Content of a line for the error, such as "a point".

    Returns
    -------
    numbers : (number of lines, number of columns) array

    Raises
    ------
    FormatError
        If a line has too few columns, something else than a number there, or commas of unclear meaning.
    """
    if not len(lines) or not columns:
        return np.empty((len(lines), len(columns)))
    try:
        return _loaded(lines.content, columns)
    except ValueError:
        respelt = [_FORTRAN_EXPONENT.sub(b"e", line) for line in _with_points(lines)]
    try:
        return _loaded(respelt, columns)
    except ValueError:
        wrong = next((place for place, line in enumerate(respelt) if not _has_numbers(line, columns)), 0)
        raise lines.unexpected(wrong, expected) from None


def _loaded(lines: list[bytes], columns: Sequence[int]) -> FloatArray:
    if not all(lines):
        raise ValueError("numpy skips blank lines")
    numbers: FloatArray = np.loadtxt(lines, usecols=columns, ndmin=2, comments=None, encoding="latin-1")
    return numbers


def _with_points(lines: Lines) -> list[bytes]:
    """Write decimal points for decimal commas, in lines whose numbers have blanks between them."""
    words = [
        (place, word) for place, line in enumerate(lines.content) if b"," in line for word in line.split()
    ]
    words = [(place, word) for place, word in words if b"," in word]
    if not words or not all(DECIMAL_COMMA.fullmatch(word) for _, word in words):
        return lines.content  # which says what is wrong
    check_thousands(lines, words)
    return [line.replace(b",", b".") for line in lines.content]


def check_thousands(lines: Lines, words: Sequence[tuple[int, bytes]]) -> None:
    """Raise `FormatError` if the commas of all words may separate thousands as well as decimals.

    Parameters
    ----------
    lines : Lines
    words : sequence of (int, bytes)
        Numbers with commas, and the places of their lines.
    """
    if all(_THOUSANDS.fullmatch(word) for _, word in words):
        place, word = words[0]
        number = word.decode()
        raise FormatError(
            f"has '{number}' in line {lines.numbers[place]:,}, which may be {number.replace(',', '.', 1)} or "
            f"{number.replace(',', '')}; export it with decimal points and without commas"
        )


def parse_polygons(
    lines: Lines, column: int, vertex_count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Parse lines of polygons: the number of corners, then the vertices counted from 0.

    Parameters
    ----------
    lines : Lines
        Values behind the vertices, such as a colour, are left out.
    column : int
        Column of the number of corners.
    vertex_count : int
        Number of vertices of the file.

    Returns
    -------
    corners : (c,) array of int
    sizes : (number of lines,) array of int
        As in `Polygons`.

    Raises
    ------
    FormatError
        If a line is not a polygon, or names a vertex that is not there.
    """
    sizes = _whole_numbers(lines, [column])[:, 0]
    wrong = (sizes < 0) | (sizes > np.fromiter(map(len, lines.content), np.int64, len(lines)))
    if wrong.any():
        raise lines.unexpected(int(wrong.argmax()), A_POLYGON)
    corners = parse_corners(lines, column + 1, sizes)
    out = (corners < 0) | (corners >= vertex_count)
    if out.any():
        of_surface = np.flatnonzero(out & np.repeat(sizes > 2, sizes))
        if len(of_surface):
            place = int(np.repeat(np.arange(len(sizes)), sizes)[of_surface[0]])
            raise lines.unexpected(place, f"a polygon of the vertices 0 to {vertex_count - 1:,}")
    return corners, sizes


def parse_corners(
    lines: Lines, column: int, sizes: NDArray[np.int64], expected: str = A_POLYGON
) -> NDArray[np.int64]:
    """Parse lines with a known number of corners each, which begin at a column; see `parse_polygons`."""
    starts = np.cumsum(sizes) - sizes
    corners = np.empty(int(sizes.sum()), np.int64)
    for size in np.unique(sizes).tolist():
        rows = np.flatnonzero(sizes == size)
        chosen = lines if len(rows) == len(lines) else lines.chosen(rows.tolist())
        numbers = _whole_numbers(chosen, range(column, column + size), expected)
        corners[starts[rows, None] + np.arange(size)] = numbers
    return corners


def word_numbers(lines: Lines, expected: str) -> FloatArray:
    """Parse all numbers of some lines as one sequence, wherever the lines end."""
    words = b"\n".join(lines.content).split()
    try:
        return np.array(words).astype(np.float64) if words else np.empty(0)
    except ValueError:
        place = next(
            place
            for place, line in enumerate(lines.content)
            if not all(NUMBER.fullmatch(word) for word in line.split())
        )
        raise lines.unexpected(place, expected) from None


def _whole_numbers(lines: Lines, columns: Sequence[int], expected: str = A_POLYGON) -> NDArray[np.int64]:
    """Parse columns of polygons; some programs write whole numbers as 3.0."""
    numbers = parse_numbers(lines, columns, expected)
    with np.errstate(invalid="ignore"):
        whole = numbers.astype(np.int64)
    wrong = (whole != numbers).any(axis=1)
    if wrong.any():
        raise lines.unexpected(int(wrong.argmax()), expected)
    return whole


def _has_numbers(line: bytes, columns: Sequence[int]) -> bool:
    words = line.split()
    return len(words) > max(columns) and all(NUMBER.fullmatch(words[column]) for column in columns)
