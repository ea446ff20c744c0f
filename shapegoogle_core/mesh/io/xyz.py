# SPDX-License-Identifier: MIT
"""Reading XYZ: texts of scanners with one point a line, in many dialects."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, check_point_count
from shapegoogle_core.mesh.io.numbers import DECIMAL_COMMA, NUMBER, check_thousands, parse_numbers
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import Lines, filled_lines, plain_text, quoted
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["read_xyz"]

_AXES = (b"x", b"y", b"z")
_COMMENT = re.compile(rb"(#|//).*")
_SEPARATORS = re.compile(rb"[,;\s]+")
_UNIT = re.compile(rb"[(\[].*|[\"']")
_DECIMALS = re.compile(rb"\d+(?:[eE][-+]?\d+)?")
_A_POINT = "a point (three coordinates)"


def read_xyz(file: MeshFile) -> Polygons:
    """Read the coordinates of each line; normals, colours and intensities behind them are left out.

    Blanks, tabs, commas or semicolons separate the columns; numbers may have decimal commas where these
    cannot be separators. Comments begin with # or //. A line before the points may name the columns, among
    them x, y and z, or say how many points follow. A first column that counts the points is left out.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    points : Polygons
        Without faces.

    Raises
    ------
    FormatError
        If a line is not a point, the columns can be read in two ways, or there are too many points.
    """
    text = plain_text(file.data)
    comments = b"#" in text or b"//" in text
    lines = filled_lines(_COMMENT.sub(b"", text) if comments else text)
    lines = _without_count(lines)
    names, lines = _named_columns(lines)
    if not len(lines):
        raise FormatError("has no points: it is empty, or not an XYZ file; export it again")
    check_point_count(len(lines), file.max_faces)
    if b"," in text or b";" in text:
        lines = _blank_separated(lines)
    column_count = len(lines.content[0].split())
    if names and len(names) != column_count:
        # Such as "Point ID": which of them is x can only be guessed.
        raise FormatError(
            f"names {len(names)} columns before line {lines.numbers[0]:,}, which has {column_count}; correct "
            "the names, or remove them"
        )
    if not names and comments:
        names = _names_in_comment(text, column_count)
    columns = _axes(names)
    if columns is not None:
        return Polygons.from_points(parse_numbers(lines, columns, _A_POINT))
    if column_count == 3:
        return Polygons.from_points(parse_numbers(lines, (0, 1, 2), _A_POINT))
    return _without_ids(lines)


def _without_count(lines: Lines) -> Lines:
    """Remove a first line that is the number of the points."""
    if not len(lines) or not lines.content[0].strip().isdigit():
        return lines
    announced, rest = int(lines.content[0]), lines.part(1)
    _, points = _named_columns(rest)
    if announced != len(points):
        raise DamagedError(
            f"announces {announced:,} points in line {lines.numbers[0]:,}, but {len(points):,} lines follow"
        )
    return rest


def _named_columns(lines: Lines) -> tuple[list[bytes], Lines]:
    """Return the names of the columns if the first line has some, and the lines behind it."""
    if not len(lines):
        return [], lines
    words = [word for word in _SEPARATORS.split(lines.content[0].strip()) if word]
    if all(NUMBER.fullmatch(word) for word in words):
        return [], lines
    if _axes(words) is None:
        if any(word.isalpha() for word in words) or not re.search(rb"\d", lines.content[0]):
            expected = "a point (three coordinates) or the names of the columns, among them x, y and z,"
            raise lines.unexpected(0, expected)
        return [], lines  # a damaged point
    return words, lines.part(1)


def _axes(words: list[bytes]) -> tuple[int, int, int] | None:
    names = [_UNIT.sub(b"", word.lower()) for word in words]
    if any(names.count(axis) != 1 for axis in _AXES):
        return None
    x, y, z = (names.index(axis) for axis in _AXES)
    return x, y, z


def _names_in_comment(text: bytes, column_count: int) -> list[bytes]:
    """Return the words of the last comment before the points, if they are as many as there are columns."""
    names: list[bytes] = []
    for line in text.split(b"\n", 100)[:100]:
        comment = re.match(rb"\s*(?:#|//)[#/]*(.*)", line)
        if comment is None and line.strip():
            break
        if comment is not None:
            names = [word for word in _SEPARATORS.split(comment[1].strip()) if word]
    return names if len(names) == column_count else []


def _blank_separated(lines: Lines) -> Lines:
    """Separate columns by blanks, and decimals by points."""
    content = lines.content
    commas = any(b"," in line for line in content)
    if any(b";" in line for line in content):
        for place, line in enumerate(content):
            if b";" not in line:
                raise lines.unexpected(place, "a point with semicolons between its columns")
        if commas:  # which can only belong to numbers
            _check_decimal_commas(lines, [line.split(b";") for line in content])
        return lines.with_content([line.replace(b";", b" ").replace(b",", b".") for line in content])
    if not commas:
        return lines
    fields = [line.split() for line in content]
    if _commas_separate(lines, fields):
        return lines.with_content([line.replace(b",", b" ") for line in content])
    _check_decimal_commas(lines, fields)
    return lines.with_content([line.replace(b",", b".") for line in content])


def _commas_separate(lines: Lines, fields: list[list[bytes]]) -> bool:
    """Tell whether commas separate columns, or else decimals; raise `FormatError` if they may do both."""
    words = [(place, word.strip(b",").split(b",")) for place, word in _with_commas(fields)]
    words = [(place, parts) for place, parts in words if len(parts) > 1]
    if not words:
        return True  # there are blanks beside all of them
    fewest_words = min(map(len, fields))
    if any(not _may_be_decimals(parts) for _, parts in words):
        if fewest_words >= 3:
            check_thousands(lines, [(place, b",".join(parts)) for place, parts in words])
        return True
    if fewest_words == 1 and any(len(parts) < 6 for _, parts in words):
        return True  # too few for three numbers with decimals
    commas_at_ends = any(word[:1] == b"," or word[-1:] == b"," for _, word in _with_commas(fields))
    for place, parts in words:
        if len(parts) > 2 or b"." in parts[0] or commas_at_ends or fewest_words < 3:
            word = quoted(b",".join(parts))
            raise FormatError(
                f"has {word} in line {lines.numbers[place]:,}, where commas may separate columns or "
                "decimals; export it with decimal points, and with blanks or semicolons between the columns"
            )
    return False


def _may_be_decimals(parts: list[bytes]) -> bool:
    """Tell whether a word with commas may begin with decimal commas, and commas between the numbers."""
    if len(parts) >= 6:  # a point, whatever follows it
        return all(_DECIMALS.fullmatch(part) for part in parts[1:6:2])
    return len(parts) % 2 == 0 and all(_DECIMALS.fullmatch(part) for part in parts[1::2])


def _check_decimal_commas(lines: Lines, fields: list[list[bytes]]) -> None:
    words = [(place, word.strip()) for place, word in _with_commas(fields)]
    for place, word in words:
        if not DECIMAL_COMMA.fullmatch(word):
            raise lines.unexpected(place, "a point with decimal points, or with decimal commas,")
    check_thousands(lines, words)


def _with_commas(fields: list[list[bytes]]) -> Iterator[tuple[int, bytes]]:
    for place, row in enumerate(fields):
        for word in row:
            if b"," in word:
                yield place, word


def _without_ids(lines: Lines) -> Polygons:
    """Read points of four and more columns, of which the first may be the number of the point."""
    points = parse_numbers(lines, (0, 1, 2), _A_POINT)
    first = points[:, 0]
    if not _are_whole(first):
        return Polygons.from_points(points)
    if min(len(line.split(None, 4)) for line in lines.content) < 4:
        return Polygons.from_points(points)
    if first[0] in (0, 1) and (np.diff(first) == 1).all():
        note = (
            f"has a first column that counts the points from {first[0]:.0f}, so x, y and z were read from "
            "the next three; name the columns in a first line if this is wrong"
        )
        return Polygons.from_points(parse_numbers(lines, (1, 2, 3), _A_POINT), (note,))
    all_differ = len(np.unique(first)) == len(first)
    if not _are_whole(points[:, 1]) or (all_differ and not _are_whole(points[:, 2])):
        raise FormatError(
            "has a whole number in the first column of each line, which may be the number of the point or "
            "its x; remove this column, or name all columns in a first line such as 'id x y z'"
        )
    return Polygons.from_points(points)


def _are_whole(numbers: FloatArray) -> bool:
    return bool((numbers == np.floor(numbers)).all())
