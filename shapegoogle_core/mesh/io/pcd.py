# SPDX-License-Identifier: MIT
"""Reading PCD, the files of the Point Cloud Library: text, binary or compressed with LZF."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, check_point_count
from shapegoogle_core.mesh.io.numbers import parse_numbers
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import Lines, filled_lines, lines_of, plain_text, quoted, without_mark
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["read_pcd"]

_TYPES = {"F": "f", "I": "i", "U": "u"}
_A_POINT = "a point (a number for each field)"
_DATA_LINE = re.compile(rb"(?:\A|(?<=[\r\n]))[ \t]*DATA[ \t]+(\w+)[ \t]*(?:\r\n|\n|\r|\Z)", re.IGNORECASE)


@dataclass(frozen=True)
class _Axis:
    """A coordinate in the record of a point."""

    type: np.dtype[Any]
    column: int  # values before it
    offset: int  # bytes before it


@dataclass(frozen=True)
class _Header:
    axes: list[_Axis]
    record_size: int
    point_count: int


def read_pcd(file: MeshFile) -> Polygons:
    """Read the positions of a PCD file of version 0.7 or before, also of an organised cloud.

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
        If the header or the data are damaged, or there are too many points.
    """
    data = without_mark(file.data)
    head = _DATA_LINE.search(data[: 1 << 16])
    if head is None:
        raise FormatError("has no PCD header with a line DATA; it is not a PCD file or was cut short")
    text = plain_text(data[: head.start()])
    header = _read_header(filled_lines(re.sub(rb"#.*", b"", text)))
    count, size = header.point_count, header.record_size
    check_point_count(count, file.max_faces)
    body, encoding, more = data[head.end() :], head[1].decode().lower(), ""
    if encoding == "ascii":
        lines = filled_lines(plain_text(body), plain_text(data[: head.end()]).count(b"\n") + 1)
        more = lines_of(len(lines) - count) if len(lines) > count else ""
        points = parse_numbers(lines.first(count), [axis.column for axis in header.axes], _A_POINT)
    elif encoding == "binary":
        if len(body) < count * size:
            raise _cut_short(count, head.end(), count * size, len(body))
        more = f"{len(body) - count * size:,} bytes" if len(body) >= (count + 1) * size else ""
        columns = [np.ndarray(count, axis.type, body, axis.offset, size) for axis in header.axes]
        points = _stacked(columns)
    elif encoding == "binary_compressed":
        packed_size, unpacked_size = struct.unpack_from("<2I", body.ljust(8, b"\0"))
        if len(body) < 8 + packed_size:
            raise _cut_short(count, head.end(), 8 + packed_size, len(body))
        if unpacked_size != count * size:
            raise DamagedError(
                f"announces {unpacked_size:,} unpacked bytes at byte {head.end() + 4:,}, "
                f"but its {count:,} points take {count * size:,}"
            )
        # Unpacked, each field stands for all points before the next one.
        fields = _unpack(body[8 : 8 + packed_size], unpacked_size, head.end() + 8)
        columns = [np.frombuffer(fields, axis.type, count, axis.offset * count) for axis in header.axes]
        points = _stacked(columns)
    else:
        number = plain_text(data[: head.end()].rstrip()).count(b"\n") + 1
        expected = "ascii, binary or binary_compressed"
        raise FormatError(
            f"has the unknown kind of data {quoted(encoding)} in line {number:,}, "
            f"where {expected} is expected; export it again"
        )
    note = f"has {more} behind the {count:,} points that it announces; they were not read"
    return Polygons.from_points(points, (note,) if more else ())


def _read_header(lines: Lines) -> _Header:
    places = {line.split()[0].upper(): place for place, line in enumerate(lines.content)}

    def values(key: bytes, expected: str, pattern: str, count: int | None = None) -> list[str]:
        """Return the words behind a key; raise `DamagedError` if one of them does not match."""
        if key not in places:
            raise DamagedError(f"has no line {key.decode()} in its PCD header")
        place = places[key]
        found = lines.content[place].decode("latin-1").split()[1:]
        if (count is not None and len(found) != count) or not all(
            re.fullmatch(pattern, word) for word in found
        ):
            raise lines.unexpected(place, expected)
        return found

    names = [name.lower() for name in values(b"FIELDS", "FIELDS and their names", r"\S+")]
    fields = len(names)
    sizes = values(b"SIZE", f"SIZE and {fields} times 1, 2, 4 or 8 bytes", "[1248]", fields)
    kinds = values(b"TYPE", f"TYPE and {fields} times I, U or F", "[IUF]", fields)
    counts = ["1"] * fields
    if b"COUNT" in places:
        counts = values(b"COUNT", f"COUNT and {fields} numbers", r"\d{1,4}", fields)
    axes, column, offset = dict[str, _Axis](), 0, 0
    for name, size, kind, count in zip(names, map(int, sizes), kinds, map(int, counts), strict=True):
        if name in ("x", "y", "z") and name not in axes and count == 1:
            if kind == "F" and size == 1:
                raise lines.unexpected(places[b"SIZE"], f"2, 4 or 8 bytes for {name}")
            axes[name] = _Axis(np.dtype(f"<{_TYPES[kind]}{size}"), column, offset)
        column, offset = column + count, offset + count * size
    if len(axes) < 3:
        raise lines.unexpected(places[b"FIELDS"], "a list of fields with x, y and z, of one value each,")
    expected = "a number of points"
    if b"POINTS" in places:
        point_count = int(values(b"POINTS", expected, r"\d{1,18}", 1)[0])
    else:
        width, height = (values(key, expected, r"\d{1,9}", 1)[0] for key in (b"WIDTH", b"HEIGHT"))
        point_count = int(width) * int(height)
    return _Header([axes[name] for name in "xyz"], offset, point_count)


def _unpack(packed: bytes, size: int, position: int) -> bytes:
    """Unpack the format of LibLZF: runs of plain bytes, and references to earlier bytes."""
    out, at = bytearray(), 0
    try:
        while at < len(packed):
            control = packed[at]
            at += 1
            if control < 32:
                out += packed[at : at + control + 1]
                at += control + 1
                continue
            length = control >> 5
            if length == 7:
                length += packed[at]
                at += 1
            length += 2
            start = len(out) - ((control & 31) << 8) - packed[at] - 1
            at += 1
            if start < 0:
                raise IndexError(start)
            if start + length <= len(out):
                out += out[start : start + length]
            else:  # it runs into what it writes: a repeated pattern
                pattern = bytes(out[start:])
                out += (pattern * (length // len(pattern) + 1))[:length]
            if len(out) > size:
                break
    except IndexError as error:
        raise DamagedError(
            f"has compressed data that cannot be unpacked at byte {position + at:,}"
        ) from error
    if len(out) != size:
        raise DamagedError(f"has compressed data of {len(out):,} bytes instead of {size:,}")
    return bytes(out)


def _stacked(columns: list[NDArray[Any]]) -> FloatArray:
    with np.errstate(invalid="ignore"):  # some kinds of NaN
        points: FloatArray = np.stack(columns, axis=1).astype(np.float64)
    return points


def _cut_short(point_count: int, start: int, size: int, found: int) -> DamagedError:
    return DamagedError(
        f"announces {point_count:,} points, which take {size:,} bytes from byte {start:,} on, "
        f"but has {found:,} there"
    )
