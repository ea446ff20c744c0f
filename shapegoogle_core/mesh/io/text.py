# SPDX-License-Identifier: MIT
"""Text formats: one decoder for all of them, and tables of numbers parsed many lines at a time."""

from __future__ import annotations

import codecs
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = [
    "filled_lines",
    "parse_corners",
    "parse_numbers",
    "parse_polygons",
    "plain_text",
    "quoted",
    "unexpected",
    "without_mark",
]

_UTF_16 = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}


def without_mark(data: bytes) -> bytes:
    """Remove a byte order mark, and decode UTF-16; line ends stay, since binary data may follow a header."""
    if encoding := _UTF_16.get(data[:2]):
        return data[2:].decode(encoding, "replace").encode()
    return data.removeprefix(codecs.BOM_UTF8)


def plain_text(data: bytes) -> bytes:
    r"""Decode a text file of any common encoding.

    Parameters
    ----------
    data : bytes
        ASCII, any extension of it to eight bits, UTF-8, or UTF-16 with a byte order mark.

    Returns
    -------
    text : bytes
        An extension of ASCII without a byte order mark; lines end with ``\n``.
    """
    text = without_mark(data)
    return text.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in text else text


def filled_lines(text: bytes, count: int) -> list[bytes]:
    """Return the first `count` lines that are not blank; `DamagedError` if there are fewer."""
    lines = [line for line in text.split(b"\n") if line and not line.isspace()]
    if len(lines) < count:
        raise DamagedError(f"ends after {len(lines):,} of the {count:,} lines that it announces")
    return lines[:count]


def parse_numbers(lines: Sequence[bytes], columns: Sequence[int], expected: str) -> FloatArray:
    """Parse some columns of lines of numbers with blanks between them.

    Parameters
    ----------
    lines : sequence of bytes
        Lines may have more columns, and not all the same number of them.
    columns : sequence of int
        Columns to parse, counted from 0.
    expected : str
        Name of a line's content for the error, such as "a point".

    Returns
    -------
    numbers : (number of lines, number of columns) array

    Raises
    ------
    DamagedError
        If a line has too few columns, or something else than a number there.
    """
    if not lines or not columns:
        return np.empty((len(lines), len(columns)))
    try:
        return np.loadtxt(lines, usecols=columns, ndmin=2, comments=None, encoding="latin-1")
    except ValueError as error:
        wrong = next((line for line in lines if not _has_numbers(line, columns)), lines[-1])
        raise unexpected(wrong, expected) from error


def parse_polygons(lines: Sequence[bytes], column: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Parse lines of polygons: the number of corners, then the vertices counted from 0.

    Parameters
    ----------
    lines : sequence of bytes
        Values behind the vertices, such as a colour, are left out.
    column : int
        Column of the number of corners.

    Returns
    -------
    corners : (c,) array of int
    sizes : (number of lines,) array of int
        As in `Polygons`.

    Raises
    ------
    DamagedError
        If a line is not a polygon.
    """
    sizes = _whole_numbers(lines, [column])[:, 0]
    wrong = (sizes < 0) | (sizes > np.fromiter(map(len, lines), np.int64, len(lines)))
    if wrong.any():
        raise unexpected(lines[int(wrong.argmax())], "a polygon")
    return parse_corners(lines, column + 1, sizes), sizes


def parse_corners(lines: Sequence[bytes], column: int, sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Parse lines with a known number of corners each, which begin at a column; see `parse_polygons`."""
    starts = np.cumsum(sizes) - sizes
    corners = np.empty(int(sizes.sum()), np.int64)
    for size in np.unique(sizes).tolist():
        rows = np.flatnonzero(sizes == size)
        chosen = lines if len(rows) == len(lines) else [lines[row] for row in rows.tolist()]
        numbers = _whole_numbers(chosen, range(column, column + size))
        corners[starts[rows, None] + np.arange(size)] = numbers
    return corners


def unexpected(line: bytes, expected: str) -> DamagedError:
    """Make the error for a line that has something else than expected."""
    return DamagedError(f"has a line {quoted(line)} that is not {expected}")


def quoted(text: bytes | str) -> str:
    r"""Quote a piece of a file for a message: at most 60 characters, question marks for unprintable ones.

    Parameters
    ----------
    text : bytes or str
        Bytes are in UTF-8, or any encoding of one byte for each character.

    Returns
    -------
    quoted : str
        Between single quotation marks.

    Examples
    --------
    >>> from shapegoogle_core.mesh.io.text import quoted
    >>> quoted(b"v 1.0 \x00\x1f 3.0 ")
    "'v 1.0 ?? 3.0'"
    """
    decoded = text if isinstance(text, str) else _decoded(text)
    shown = "".join(character if character.isprintable() else "?" for character in decoded.strip()[:60])
    return f"'{shown}'"


def _decoded(text: bytes) -> str:
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("latin-1")


def _whole_numbers(lines: Sequence[bytes], columns: Sequence[int]) -> NDArray[np.int64]:
    """Parse columns of polygons; some programs write whole numbers as 3.0."""
    numbers = parse_numbers(lines, columns, "a polygon")
    with np.errstate(invalid="ignore"):
        whole = numbers.astype(np.int64)
    wrong = (whole != numbers).any(axis=1)
    if wrong.any():
        raise unexpected(lines[int(wrong.argmax())], "a polygon")
    return whole


def _has_numbers(line: bytes, columns: Sequence[int]) -> bool:
    words = line.split()
    try:
        return all(isinstance(float(words[column]), float) for column in columns)
    except (IndexError, ValueError):
        return False
