# SPDX-License-Identifier: MIT
"""PLY, the Stanford polygon format: text and both binary kinds."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.formats.common import (
    FormatError,
    Geometry,
    Polygons,
    check_face_count,
    fan_triangles,
    file_size,
    lines_of,
    points_of,
)

__all__ = ["read_ply"]

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
    "int64": "i8",
    "uint64": "u8",
}
_BYTE_ORDERS = {b"ascii": "", b"binary_little_endian": "<", b"binary_big_endian": ">"}
_CORNER_NAMES = ("vertex_indices", "vertex_index")
_LONGEST_HEADER = 10_000  # lines


@dataclass(frozen=True)
class _Property:
    name: str
    type: str  # numpy's code of the value, or of a list's item
    count_type: str = ""  # numpy's code of a list's length; empty: a single value


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


def read_ply(path: Path, max_faces: int) -> Geometry:
    """Read the vertices and faces of a PLY file.

    Parameters
    ----------
    path : Path
    max_faces : int

    Returns
    -------
    vertices : (n, 3) array
    faces : (m, 3) array
        Polygons become fans.

    Raises
    ------
    FormatError
    """
    vertices = np.empty((0, 3))
    faces = np.empty((0, 3), np.int64)
    with path.open("rb") as file:
        byte_order, elements = _read_header(file)
        _check_counts(elements, byte_order, file_size(path) - file.tell(), max_faces)
        lines = lines_of(file, comment=b"")
        for element in elements:
            if element.name == "vertex":
                vertices = (
                    _binary_points(file, element, byte_order) if byte_order else _text_points(lines, element)
                )
            elif byte_order:
                corners, sizes = _binary_lists(file, element, byte_order)
                if element.name == "face":
                    check_face_count(int(np.maximum(sizes - 2, 0).sum()), max_faces)
                    faces = fan_triangles(corners, sizes)
            elif element.name == "face":
                faces = _text_triangles(lines, element, max_faces)
            else:
                for _ in range(element.count):
                    next(lines, None)
    return vertices, faces


def _read_header(file: BinaryIO) -> tuple[str, list[_Element]]:
    """Return the byte order, empty for text, and the elements; the file then stands at the data."""
    if file.readline(16).strip() != b"ply":
        raise FormatError("does not begin with the word ply: it is empty, or no PLY file; export it again")
    byte_order: str | None = None
    elements: list[_Element] = []
    for number, words in islice(lines_of(file, comment=b""), _LONGEST_HEADER):
        try:
            match words:
                case [b"format", kind, *_]:
                    byte_order = _BYTE_ORDERS[kind]
                case [b"element", name, count]:
                    elements.append(_Element(name.decode(), int(count)))
                case [b"property", b"list", count_type, item_type, name]:
                    sort = _TYPES[item_type.decode()], _TYPES[count_type.decode()]
                    elements[-1].properties.append(_Property(name.decode(), *sort))
                case [b"property", value_type, name]:
                    elements[-1].properties.append(_Property(name.decode(), _TYPES[value_type.decode()]))
                case [b"end_header"] if byte_order is not None:
                    return byte_order, elements
                case [b"comment" | b"obj_info", *_]:
                    pass
                case _:
                    raise ValueError(b" ".join(words).decode(errors="replace"))
        except (ValueError, KeyError, IndexError) as error:
            raise FormatError(
                f"has a damaged PLY header, line {number + 1}: {error}; export it again"
            ) from error
    raise FormatError("has a PLY header without end: it was cut short; copy or export it again")


def _check_counts(elements: list[_Element], byte_order: str, remaining: int, max_faces: int) -> None:
    """Refuse counts that the rest of the file cannot hold before any memory is asked for."""
    needed = 0
    for element in elements:
        if element.name == "face":
            check_face_count(element.count, max_faces)
        sizes = [np.dtype(each.count_type or each.type).itemsize for each in element.properties]
        # In a text a value takes a digit and a blank, but the last blank may be missing.
        needed += element.count * (sum(sizes) if byte_order else 2 * len(sizes))
        if element.count < 0 or needed > remaining + 1:
            raise FormatError(
                f"claims {element.count:,} times the element {element.name!r}, {needed:,} bytes or more, but "
                f"only {remaining:,} are left; it is damaged or was cut short: copy or export it again"
            )


def _position(element: _Element, *names: str) -> int:
    for index, each in enumerate(element.properties):
        if each.name in names:
            return index
    raise FormatError(f"has an element {element.name!r} without {names[0]!r}; export it again")


def _coordinate_positions(element: _Element) -> list[int]:
    positions = [_position(element, axis) for axis in "xyz"]
    if any(each.count_type for each in element.properties):
        raise FormatError("has lists among its vertices' properties, which cannot be read; export it again")
    return positions


def _cut_short(element: _Element) -> FormatError:
    return FormatError(
        f"ends before its {element.count:,} times the element {element.name!r} are complete; it was cut "
        "short: copy or export it again"
    )


def _text_points(lines: Iterator[tuple[int, list[bytes]]], element: _Element) -> NDArray[np.float64]:
    x, y, z = _coordinate_positions(element)
    coordinates = array("d")
    for _ in range(element.count):
        number, words = next(lines, (0, []))
        if not words:
            raise _cut_short(element)
        try:
            coordinates.extend((float(words[x]), float(words[y]), float(words[z])))
        except (ValueError, IndexError) as error:
            raise FormatError(
                f"has no {element.name} in line {number} after its header ({error}); it is damaged"
            ) from error
    return points_of(coordinates)


def _text_triangles(
    lines: Iterator[tuple[int, list[bytes]]], element: _Element, max_faces: int
) -> NDArray[np.int64]:
    before = element.properties[: _position(element, *_CORNER_NAMES)]
    polygons = Polygons(max_faces)
    for _ in range(element.count):
        number, words = next(lines, (0, []))
        if not words:
            raise _cut_short(element)
        try:
            start = 0
            for each in before:
                start += 1 + int(words[start]) if each.count_type else 1
            size = int(words[start])
            if not 0 <= size < len(words) - start:
                raise ValueError(f"a face of {size} corners has {len(words) - start - 1} numbers")
            polygons.append(map(int, words[start + 1 : start + 1 + size]))
        except (ValueError, IndexError, OverflowError) as error:
            raise FormatError(
                f"has no {element.name} in line {number} after its header ({error}); it is damaged"
            ) from error
    return polygons.triangles()


def _binary_points(file: BinaryIO, element: _Element, byte_order: str) -> NDArray[np.float64]:
    positions = _coordinate_positions(element)
    row = np.dtype([(f"{index}", byte_order + each.type) for index, each in enumerate(element.properties)])
    rows = np.fromfile(file, row, element.count)
    if len(rows) < element.count:
        raise _cut_short(element)
    return np.stack([rows[f"{position}"].astype(np.float64) for position in positions], axis=1)


def _binary_lists(
    file: BinaryIO, element: _Element, byte_order: str
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Read past an element; return the corners that its rows list, row after row, and how many each lists."""
    wanted = _position(element, *_CORNER_NAMES) if element.name == "face" else None
    if element.count == 0:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    data = file.read()
    end = len(data)
    row = _row_like_first(data, element, byte_order)
    if row is not None and element.count * row.itemsize <= end:
        rows = np.frombuffer(data, row, element.count)
        lengths = [name for name in row.names or () if name.startswith("length")]
        if all((rows[name] == rows[name][0]).all() for name in lengths):
            file.seek(element.count * row.itemsize - end, 1)
            corners = np.empty((element.count, 0)) if wanted is None else rows[f"value{wanted}"]
            return corners.astype(np.int64).ravel(), np.full(element.count, corners.shape[1], np.int64)
    starts, sizes, used = _walk_rows(data, element, byte_order, wanted)
    file.seek(used - end, 1)
    if wanted is None:
        return np.empty(0, np.int64), sizes
    corner_type = np.dtype(byte_order + element.properties[wanted].type)
    first_byte = np.repeat(starts - (np.cumsum(sizes) - sizes) * corner_type.itemsize, sizes)
    first_byte += np.arange(len(first_byte)) * corner_type.itemsize
    corner_bytes = np.frombuffer(data, np.uint8)[first_byte[:, None] + np.arange(corner_type.itemsize)]
    return corner_bytes.view(corner_type).ravel().astype(np.int64), sizes


def _row_like_first(data: bytes, element: _Element, byte_order: str) -> np.dtype[np.void] | None:
    """Type of a row with lists as long as the first row's, as in most files; None if that passes the end."""
    fields: list[tuple[str, str, tuple[int, ...]]] = []
    for index, each in enumerate(element.properties):
        length = 0
        if each.count_type:
            fields.append((f"length{index}", byte_order + each.count_type, ()))
            position = np.dtype(fields).itemsize
            if position > len(data):
                return None
            length = int(np.frombuffer(data[:position], np.dtype(fields))[f"length{index}"][0])
            if not 0 <= length <= len(data):
                return None
        fields.append((f"value{index}", byte_order + each.type, (length,) if each.count_type else ()))
    return np.dtype(fields)


def _walk_rows(
    data: bytes, element: _Element, byte_order: str, wanted: int | None
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """Where the wanted list of each row begins, how long it is, and where the rows end."""
    order: Literal["little", "big"] = "big" if byte_order == ">" else "little"
    steps = [
        (
            index == wanted,
            np.dtype(each.type).itemsize,
            np.dtype(each.count_type).itemsize if each.count_type else 0,
            each.count_type.startswith("i"),
        )
        for index, each in enumerate(element.properties)
    ]
    starts, sizes = array("q"), array("q")
    position = 0
    for _ in range(element.count):
        for is_wanted, item_bytes, length_bytes, signed in steps:
            length = 1
            if length_bytes:
                length = int.from_bytes(data[position : position + length_bytes], order, signed=signed)
                position += length_bytes
                if length < 0:
                    raise FormatError(
                        f"has a list of {length} items in an element {element.name!r}; it is damaged"
                    )
            if is_wanted:
                starts.append(position)
                sizes.append(length)
            position += length * item_bytes
        if position > len(data):
            raise _cut_short(element)
    return np.array(starts, np.int64), np.array(sizes, np.int64), position
