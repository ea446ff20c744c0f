# SPDX-License-Identifier: MIT
"""The rows of a PLY file, text or binary: the columns that are read of each element."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, FormatError
from shapegoogle_core.mesh.io.numbers import A_POLYGON, parse_numbers, parse_polygons, word_numbers
from shapegoogle_core.mesh.io.ply.header import Element, Property, Type
from shapegoogle_core.mesh.io.text import Lines, filled_lines, lines_of, quoted
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Column", "Columns", "binary_columns", "text_columns"]

Column = tuple[NDArray[Any], NDArray[np.int64]]
"""Values of a property in all rows, and how many are in each row: 1 if the property is not a list."""

Columns = dict[str, list[Column]]
"""Columns of the wanted properties of each element, by its name."""


def text_columns(text: bytes, first_number: int, elements: Sequence[Element]) -> tuple[Columns, str]:
    """Read the rows of a PLY in text form, usually one a line.

    Parameters
    ----------
    text : bytes
        What follows the header.
    first_number : int
        Number of its first line in the file.
    elements : sequence of Element
        All that have rows, in their order.

    Returns
    -------
    columns : dict of str to list of Column
    rest : str
        What follows the rows, such as "3 lines", or empty.

    Raises
    ------
    FormatError
        If a row is damaged, or some are missing.
    """
    lines = filled_lines(text, first_number)
    count = sum(element.length for element in elements)
    try:
        columns = _line_by_line(lines.first(count), elements)
    except FormatError:
        wrapped = _word_by_word(lines, elements)
        if wrapped is None:
            raise
        return wrapped, ""
    if len(lines) == count:
        return columns, ""
    wrapped = _word_by_word(lines, elements)
    return (columns, lines_of(len(lines) - count)) if wrapped is None else (wrapped, "")


def _line_by_line(lines: Lines, elements: Sequence[Element]) -> Columns:
    columns, first = Columns(), 0
    vertex_count = sum(element.length for element in elements if element.name == "vertex")
    for element in elements:
        rows = lines.part(first, first + element.length)
        first += element.length
        if element.name == "face":
            (place,) = element.wanted()
            rows, column = _from_column(rows, element.properties[:place], place)
            columns["face"] = [parse_polygons(rows, column, vertex_count)]
        elif element.name == "vertex" and not _has_lists(element.properties[: max(element.wanted())]):
            properties = [element.properties[place] for place in element.wanted()]
            numbers = parse_numbers(rows, element.wanted(), "a vertex (a number for each property)")
            columns["vertex"] = _vertex_columns(numbers, properties)
        elif element.wanted():  # strips, which may be as long as the file, or vertices behind a list
            expected = f"a row of the element {quoted(element.name)}"
            found = _element_of_words(word_numbers(rows, expected), 0, element)
            if found is None:
                raise rows.unexpected(0, expected)
            columns[element.name] = found[0]
    return columns


def _vertex_columns(numbers: FloatArray, properties: Sequence[Property]) -> list[Column]:
    ones = np.ones(len(numbers), np.int64)
    with np.errstate(over="ignore", invalid="ignore"):
        # The decimals of a float stand for the nearest float.
        return [
            (values.astype(each.type) if each.type.kind == "f" else values, ones)
            for values, each in zip(numbers.T, properties, strict=True)
        ]


def _from_column(lines: Lines, before: Sequence[Property], place: int) -> tuple[Lines, int]:
    """Return lines and a property's column in them: cut off at the property if lists are before it."""
    if not _has_lists(before):
        return lines, place
    rest = []
    for index, line in enumerate(lines.content):
        words, start = line.split(), 0
        for each in before:
            if each.count_type is not None and not (start < len(words) and words[start].isdigit()):
                raise lines.unexpected(index, A_POLYGON)
            start += 1 if each.count_type is None else 1 + int(words[start])
        rest.append(b" ".join(words[start:]))
    return lines.with_content(rest), 0


def _has_lists(properties: Sequence[Property]) -> bool:
    return any(each.count_type is not None for each in properties)


def _word_by_word(lines: Lines, elements: Sequence[Element]) -> Columns | None:
    """Read all rows as one sequence of numbers; None unless it has exactly as many as the header says."""
    try:
        numbers = word_numbers(lines, "a number")
    except FormatError:
        return None
    columns, place = Columns(), 0
    vertex_count = sum(element.length for element in elements if element.name == "vertex")
    for element in elements:
        found = _element_of_words(numbers, place, element)
        if found is None:
            return None
        columns[element.name], place = found
        if element.name == "face" and not _are_indices(columns["face"][0][0], vertex_count):
            return None
    return columns if place == len(numbers) else None


def _are_indices(values: NDArray[Any], count: int) -> bool:
    return bool(((values >= 0) & (values < count) & (values == np.floor(values))).all())


def _element_of_words(numbers: FloatArray, place: int, element: Element) -> tuple[list[Column], int] | None:
    """Read the rows that begin at a number; also return where they end. None if there are too few numbers."""
    properties, wanted = element.properties, element.wanted()
    if not _has_lists(properties):
        end = place + element.length * len(properties)
        if end > len(numbers):
            return None
        table = numbers[place:end].reshape(element.length, len(properties))[:, wanted]
        return _vertex_columns(table, [properties[index] for index in wanted]), end
    starts, sizes = array("q"), array("q")
    for _ in range(element.length):
        for index, each in enumerate(properties):
            count = 1
            if each.count_type is not None:
                if place >= len(numbers) or not 0 <= numbers[place] <= len(numbers):
                    return None
                count, place = int(numbers[place]), place + 1
            if index in wanted:
                starts.append(place)
                sizes.append(count)
            place += count
    if place > len(numbers):
        return None
    shape = element.length, len(wanted)
    all_starts, all_sizes = (np.array(each, np.int64).reshape(shape) for each in (starts, sizes))
    columns = []
    for index in np.argsort(np.argsort(wanted)).tolist():  # they were found in the order of the properties
        size = all_sizes[:, index]
        within = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size, size)
        columns.append((numbers[np.repeat(all_starts[:, index], size) + within], size))
    return columns, place


def binary_columns(data: bytes, position: int, elements: Sequence[Element]) -> tuple[Columns, str]:
    """Read the rows of a binary PLY.

    Parameters
    ----------
    data : bytes
    position : int
        First byte behind the header.
    elements : sequence of Element
        All that have rows, in their order.

    Returns
    -------
    columns : dict of str to list of Column
    rest : str
        What follows the rows, such as "48 bytes", if a row may be among it; else empty.

    Raises
    ------
    DamagedError
        If rows are missing.
    """
    columns, row_start = Columns(), position
    for element in elements:
        row_start = position
        columns[element.name], position = _element_columns(data, position, element)
    more = len(data) - position
    row = (position - row_start) // max(elements[-1].length, 1) if elements else 0
    return columns, f"{more:,} bytes" if 0 < row <= more else ""


def _element_columns(data: bytes, position: int, element: Element) -> tuple[list[Column], int]:
    """Read the columns that are wanted of the rows that begin at a byte, and where the rows end."""
    wanted = element.wanted()
    kinds = [element.properties[place].type for place in wanted]
    places, end = _places(data, position, element, 1, range(len(element.properties)))
    row, end = end - position, position + element.length * (end - position)
    counts = [
        np.ndarray(element.length, kind, data, start - kind.itemsize, row)
        for each, (start, _) in zip(element.properties, places[0], strict=True)
        if (kind := each.count_type) and end <= len(data)
    ]
    if end <= len(data) and all((count == count[0]).all() for count in counts):
        # All rows are as long as the first one, as in most files.
        columns = []
        for kind, (start, size) in zip(kinds, places[0, wanted], strict=True):
            values = np.ndarray((element.length, size), kind, data, start, (row, kind.itemsize))
            columns.append((values.ravel(), np.full(element.length, size)))
        return columns, end
    places, end = _places(data, position, element, element.length, wanted)
    order = np.argsort(np.argsort(wanted)).tolist()  # they are found in the order of the properties
    return [_gather(data, places[:, index], kind) for index, kind in zip(order, kinds, strict=True)], end


def _places(
    data: bytes, position: int, element: Element, row_count: int, wanted: Sequence[int]
) -> tuple[NDArray[np.int64], int]:
    """Find where the values of properties begin in each row and how many they are, and where the rows end.

    Returns
    -------
    places : (row_count, number of properties, 2) array of int
        Byte of the first value, and number of values.
    end : int
        First byte behind the rows.
    """
    found, last = array("q"), len(data)
    steps = [
        (_counter(each.count_type), each.type.itemsize, place in wanted)
        for place, each in enumerate(element.properties)
    ]
    for number in range(row_count):
        for counter, width, is_wanted in steps:
            count = 1
            if counter:
                position += counter.size
                if position > last:
                    raise _incomplete(last, element, number)
                (count,) = counter.unpack_from(data, position - counter.size)
                if not 0 <= count <= last:
                    raise DamagedError(
                        f"has the number {count:,} at byte {position - counter.size:,}, where the length "
                        f"of a list in row {number:,} of the element {quoted(element.name)} is expected"
                    )
            if is_wanted:
                found.append(position)
                found.append(count)
            position += count * width
        if position > last:
            raise _incomplete(last, element, number)
    return np.array(found, np.int64).reshape(row_count, len(wanted), 2), position


def _incomplete(last: int, element: Element, number: int) -> DamagedError:
    return DamagedError(
        f"ends at byte {last:,}, within row {number:,} of the {element.length:,} rows of the element "
        f"{quoted(element.name)}"
    )


def _counter(kind: Type | None) -> struct.Struct | None:
    """Make the parser of the length of a list."""
    if kind is None:
        return None
    letter = {1: "b", 2: "h", 4: "i", 8: "q"}[kind.itemsize]
    order = ">" if kind.str[0] == ">" else "<"
    return struct.Struct(order + (letter if kind.kind == "i" else letter.upper()))


def _gather(data: bytes, places: NDArray[np.int64], kind: Type) -> Column:
    """Values of lists that begin at some bytes, (n, 2) with their lengths, one list after the other."""
    starts, sizes = places.T
    content, values, ends = np.frombuffer(data, np.uint8), np.empty(sizes.sum(), kind), np.cumsum(sizes)
    for size in np.unique(sizes[sizes > 0]).tolist():
        rows = np.flatnonzero(sizes == size)
        found = content[starts[rows, None] + np.arange(size * kind.itemsize)].view(kind)
        values[ends[rows, None] - size + np.arange(size)] = found
    return values, sizes
