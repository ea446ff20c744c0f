# SPDX-License-Identifier: MIT
"""Reading PCD, the files of the Point Cloud Library: text, binary or compressed with LZF."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, check_point_count
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import filled_lines, parse_numbers, plain_text, quoted, without_mark

__all__ = ["read_pcd"]

_TYPES = {"F": "f", "I": "i", "U": "u"}
_SIZES = (1, 2, 4, 8)
_DATA_LINE = re.compile(rb"(?:\A|(?<=[\r\n]))DATA[ \t]+(\w+)[ \t]*(?:\r\n|\n|\r|\Z)")


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
    """Read the positions of a PCD file of version 0.7 or before.

    Points without a position (NaN), which stand for rays that met nothing, are left out.

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
    header = _read_header(plain_text(data[: head.start()]).decode("latin-1"))
    count, size = header.point_count, header.record_size
    check_point_count(count, file.max_faces)
    body, encoding = data[head.end() :], head[1].decode()
    if encoding == "ascii":
        lines = filled_lines(plain_text(body), count)
        points = parse_numbers(lines, [axis.column for axis in header.axes], "a point")
    elif encoding == "binary":
        if len(body) < count * size:
            raise _cut_short(count)
        columns = [np.ndarray(count, axis.type, body, axis.offset, size) for axis in header.axes]
        points = np.stack(columns, axis=1).astype(np.float64)
    elif encoding == "binary_compressed":
        packed_size, unpacked_size = struct.unpack_from("<2I", body.ljust(8, b"\0"))
        if len(body) < 8 + packed_size or unpacked_size != count * size:
            raise _cut_short(count)
        # Unpacked, each field stands for all points before the next one.
        fields = _unpack(body[8 : 8 + packed_size], unpacked_size)
        columns = [np.frombuffer(fields, axis.type, count, axis.offset * count) for axis in header.axes]
        points = np.stack(columns, axis=1).astype(np.float64)
    else:
        raise FormatError(f"has the unknown kind of data {quoted(encoding)}; export it again")
    return Polygons.from_points(points[~np.isnan(points).all(axis=1)])


def _read_header(text: str) -> _Header:
    words = (line.partition("#")[0].split() for line in text.split("\n"))
    values = {line[0].upper(): line[1:] for line in words if line}
    try:
        names = [name.lower() for name in values["FIELDS"]]
        sizes, counts = map(int, values["SIZE"]), map(int, values.get("COUNT", ["1"] * len(names)))
        axes, column, offset = dict[str, _Axis](), 0, 0
        for name, size, kind, count in zip(names, sizes, values["TYPE"], counts, strict=True):
            if size not in _SIZES or not 0 <= count < 1 << 16:
                raise ValueError(name)
            if name in ("x", "y", "z") and name not in axes and count == 1:
                axes[name] = _Axis(np.dtype(f"<{_TYPES[kind]}{size}"), column, offset)
            column, offset = column + count, offset + count * size
        point_count = int(values["WIDTH"][0]) * int(values["HEIGHT"][0])
        if "POINTS" in values:
            point_count = int(values["POINTS"][0])
        if point_count < 0:
            raise ValueError(point_count)
        return _Header([axes[name] for name in "xyz"], offset, point_count)
    except (KeyError, ValueError, IndexError, TypeError) as error:
        raise DamagedError("has a damaged PCD header") from error


def _unpack(packed: bytes, size: int) -> bytes:
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
        raise DamagedError("has compressed data that cannot be unpacked") from error
    if len(out) != size:
        raise DamagedError(f"has compressed data of {len(out):,} bytes instead of {size:,}")
    return bytes(out)


def _cut_short(point_count: int) -> DamagedError:
    return DamagedError(f"announces {point_count:,} points, but ends before them")
