# SPDX-License-Identifier: MIT
"""Reading PLY, text and binary: a header describes elements, whose rows follow.

Not left to trimesh, which in version 5.2 refuses binary polygons of several sizes, as Blender writes them,
splits vertices at texture seams and misreads texts that are cut short.
"""

from __future__ import annotations

import re
import struct
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, check_face_count
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import (
    filled_lines,
    parse_numbers,
    parse_polygons,
    plain_text,
    quoted,
    unexpected,
    without_mark,
)

__all__ = ["read_ply"]

_TYPES = {"char": "i1", "short": "i2", "int": "i4", "float": "f4", "double": "f8"}
_TYPES |= {"uchar": "u1", "ushort": "u2", "uint": "u4"}
_TYPES |= {np.dtype(kind).name: kind for kind in (*_TYPES.values(), "i8", "u8")}
_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_HEADER_END = re.compile(rb"(?<=[\r\n])end_header[ \t]*(?:\r\n|\n|\r|\Z)")

# Properties that are read; those of each tuple mean the same.
_WANTED = {"vertex": (("x",), ("y",), ("z",)), "face": (("vertex_indices", "vertex_index"),)}

_Type = np.dtype[Any]
_Column = tuple[NDArray[Any], NDArray[np.int64]]
"""Values of a property in all rows, and how many are in each row: 1 if the property is not a list."""


@dataclass(frozen=True)
class _Property:
    name: str
    type: _Type
    count_type: _Type | None  # of the length of a list; None: a single value


@dataclass(frozen=True)
class _Element:
    name: str
    length: int
    properties: list[_Property] = field(default_factory=list)

    def wanted(self) -> list[int]:
        """Places of the properties that are read."""
        found = []
        for names in _WANTED.get(self.name, ()):
            places = [place for place, each in enumerate(self.properties) if each.name in names]
            if not places:
                raise FormatError(
                    f"has the element {quoted(self.name)} without {names[0]!r}; export it again"
                )
            found.append(places[0])
        return found


def read_ply(file: MeshFile) -> Polygons:
    """Read the positions of the vertices and the corners of the faces of a PLY file.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    polygons : Polygons
        Points alone if there are no faces. Other elements and properties are left out.

    Raises
    ------
    FormatError
        If the header is damaged or does not fit the rows, or there are too many faces.
    """
    data = without_mark(file.data)
    order, elements, start = _read_header(data)
    for element in elements:
        if element.name == "face":
            check_face_count(element.length, file.max_faces)
        if not 0 <= element.length <= len(data) - start:
            raise DamagedError(
                f"claims {element.length:,} times the element {quoted(element.name)} in "
                f"{len(data) - start:,} bytes"
            )
    read = _text_columns if order == "=" else _binary_columns
    columns = read(data, start, [element for element in elements if element.length])
    vertices = np.empty((0, 3))
    if "vertex" in columns:
        vertices = np.stack([values for values, _ in columns["vertex"]], axis=1).astype(np.float64)
    if "face" not in columns:
        return Polygons.from_points(vertices)
    corners, sizes = columns["face"][0]
    return Polygons(vertices, corners.astype(np.int64), sizes)


def _read_header(data: bytes) -> tuple[str, list[_Element], int]:
    """Return the order of bytes ("=" for a text), the elements, and where their rows begin."""
    if not re.match(rb"ply\s", data):
        raise FormatError("does not begin with the word ply: it is empty, or not a PLY file; export it again")
    end = _HEADER_END.search(data, 0, 1 << 20)
    if end is None:
        raise DamagedError("has a PLY header without end")
    order, elements = "", list[_Element]()
    for line in plain_text(data[: end.start()]).decode("latin-1").split("\n")[1:]:
        try:
            match line.split():
                case ["format", encoding, *_]:
                    order = _ORDERS[encoding]
                case ["element", name, count]:
                    elements.append(_Element(name, int(count)))
                case ["property", "list", count_type, item_type, name]:
                    kind, count_kind = _type(item_type, order), _type(count_type, order)
                    if count_kind.kind == "f":
                        raise ValueError(line)
                    elements[-1].properties.append(_Property(name, kind, count_kind))
                case ["property", value_type, name]:
                    elements[-1].properties.append(_Property(name, _type(value_type, order), None))
                case ["format" | "element" | "property", *_]:
                    raise ValueError(line)
                # All other lines are comments, whatever their keyword.
        except (ValueError, KeyError, IndexError) as error:
            raise DamagedError(f"has a line {quoted(line)} in its PLY header that cannot be read") from error
    if not order:
        raise DamagedError("has a PLY header without a format")
    for element in elements:
        element.wanted()
    return order, elements, end.end()


def _type(name: str, order: str) -> _Type:
    return np.dtype(order + _TYPES[name])


def _text_columns(data: bytes, start: int, elements: Sequence[_Element]) -> dict[str, list[_Column]]:
    lines = filled_lines(plain_text(data[start:]), sum(element.length for element in elements))
    columns, first = dict[str, list[_Column]](), 0
    for element in elements:
        rows = lines[first : first + element.length]
        first += element.length
        if element.name == "face":
            (place,) = element.wanted()
            columns["face"] = [parse_polygons(*_text_column(rows, element.properties[:place], place))]
        elif element.name == "vertex":
            ones = np.ones(len(rows), np.int64)
            kinds = [element.properties[place].type for place in element.wanted()]
            numbers = parse_numbers(rows, element.wanted(), "a vertex")
            with np.errstate(over="ignore", invalid="ignore"):
                # The decimals of a float stand for the nearest float.
                columns["vertex"] = [
                    (values.astype(kind), ones) for values, kind in zip(numbers.T, kinds, strict=True)
                ]
    return columns


def _text_column(lines: list[bytes], before: Sequence[_Property], place: int) -> tuple[list[bytes], int]:
    """Return lines and a property's column in them: cut off at the property if lists are before it."""
    if not any(each.count_type for each in before):
        return lines, place
    rest = []
    for line in lines:
        words, start = line.split(), 0
        try:
            for each in before:
                start += 1 + int(words[start]) if each.count_type else 1
        except (ValueError, IndexError) as error:
            raise unexpected(line, "a polygon") from error
        rest.append(b" ".join(words[start:]))
    return rest, 0


def _binary_columns(data: bytes, position: int, elements: Sequence[_Element]) -> dict[str, list[_Column]]:
    columns = dict[str, list[_Column]]()
    for element in elements:
        columns[element.name], position = _element_columns(data, position, element)
    return columns


def _element_columns(data: bytes, position: int, element: _Element) -> tuple[list[_Column], int]:
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
    return [_gather(data, places[:, index], kind) for index, kind in enumerate(kinds)], end


def _places(
    data: bytes, position: int, element: _Element, row_count: int, wanted: Sequence[int]
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
    incomplete = DamagedError(f"has incomplete rows of the element {quoted(element.name)}")
    steps = [
        (_counter(each.count_type), each.type.itemsize, place in wanted)
        for place, each in enumerate(element.properties)
    ]
    for _ in range(row_count):
        for counter, width, is_wanted in steps:
            count = 1
            if counter:
                position += counter.size
                if position > last:
                    raise incomplete
                (count,) = counter.unpack_from(data, position - counter.size)
                if not 0 <= count <= last:
                    raise incomplete
            if is_wanted:
                found.append(position)
                found.append(count)
            position += count * width
        if position > last:
            raise incomplete
    return np.array(found, np.int64).reshape(row_count, len(wanted), 2), position


def _counter(kind: _Type | None) -> struct.Struct | None:
    """Make the parser of the length of a list."""
    if kind is None:
        return None
    letter = {1: "b", 2: "h", 4: "i", 8: "q"}[kind.itemsize]
    order = ">" if kind.str[0] == ">" else "<"
    return struct.Struct(order + (letter if kind.kind == "i" else letter.upper()))


def _gather(data: bytes, places: NDArray[np.int64], kind: _Type) -> _Column:
    """Values of lists that begin at some bytes, (n, 2) with their lengths, one list after the other."""
    starts, sizes = places.T
    content, values, ends = np.frombuffer(data, np.uint8), np.empty(sizes.sum(), kind), np.cumsum(sizes)
    for size in np.unique(sizes[sizes > 0]).tolist():
        rows = np.flatnonzero(sizes == size)
        found = content[starts[rows, None] + np.arange(size * kind.itemsize)].view(kind)
        values[ends[rows, None] - size + np.arange(size)] = found
    return values, sizes
