# SPDX-License-Identifier: MIT
"""Reading PCD, the files of the Point Cloud Library: text, binary or compressed with LZF."""

from __future__ import annotations

import re
import struct
from typing import NamedTuple

import numpy as np

from shapegoogle_core.mesh.io.file import FormatError, MeshFile, check_point_count
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import filled_lines, parse_numbers, plain_text, without_mark
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["read_pcd"]

_TYPES = {"F": "f", "I": "i", "U": "u"}
_SIZES = (1, 2, 4, 8)
_DATA_LINE = re.compile(rb"(?:\A|(?<=[\r\n]))DATA[ \t]+(\w+)[ \t]*(?:\r\n|\n|\r|\Z)")


class _Layout(NamedTuple):
    """Content of a PCD header: the record of a point, and how the records are written."""

    record: np.dtype[np.void]
    point_count: int
    encoding: str


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
    layout = _layout(plain_text(data[: head.start()]).decode("latin-1"), head[1].decode())
    check_point_count(layout.point_count, file.max_faces)
    body = data[head.end() :]
    if layout.encoding == "ascii":
        points = _from_text(plain_text(body), layout)
    elif layout.encoding == "binary":
        if len(body) < layout.point_count * layout.record.itemsize:
            raise _cut_short(layout)
        points = _positions(np.frombuffer(body, layout.record, layout.point_count))
    elif layout.encoding == "binary_compressed":
        points = _from_compressed(body, layout)
    else:
        raise FormatError(f"has the unknown kind of data {layout.encoding!r}; export it again")
    return Polygons.from_points(points[~np.isnan(points).all(axis=1)])


def _layout(header: str, encoding: str) -> _Layout:
    values = {}
    for line in header.splitlines():
        if words := line.partition("#")[0].split():
            values[words[0].upper()] = words[1:]
    try:
        names = [name.lower() for name in values["FIELDS"]]
        sizes, counts = map(int, values["SIZE"]), map(int, values.get("COUNT", ["1"] * len(names)))
        fields = []
        for name, size, kind, count in zip(names, sizes, values["TYPE"], counts, strict=True):
            if size not in _SIZES or not 0 <= count < 1 << 16:
                raise ValueError(name)
            fields.append((name, f"<{_TYPES[kind]}{size}", (count,)))
        width, height = (int(values[name][0]) for name in ("WIDTH", "HEIGHT"))
        count = int(values["POINTS"][0]) if "POINTS" in values else width * height
        # Names may repeat ("_" is filler), so records have numbers instead.
        place = [names.index(axis) for axis in "xyz"]
        titles = {index: axis for axis, index in zip("xyz", place, strict=True)}
        renamed = [(titles.get(index, f"f{index}"), *rest) for index, (_, *rest) in enumerate(fields)]
        record = np.dtype([(name, kind, shape) for name, kind, shape in renamed if shape != (0,)])
        if count < 0 or any(record[axis].shape != (1,) for axis in "xyz"):
            raise ValueError(count)
    except (KeyError, ValueError, IndexError, TypeError) as error:
        raise FormatError("has a damaged PCD header; export it again") from error
    return _Layout(record, count, encoding)


def _positions(records: np.ndarray[tuple[int], np.dtype[np.void]]) -> FloatArray:
    return np.concatenate([records[axis] for axis in "xyz"], axis=1).astype(np.float64)


def _from_text(text: bytes, layout: _Layout) -> FloatArray:
    column, place = 0, {}
    for name in layout.record.names or ():
        place[name] = column
        column += layout.record[name].shape[0]
    lines = filled_lines(text, layout.point_count)
    return parse_numbers(lines, [place[axis] for axis in "xyz"], "a point")


def _from_compressed(body: bytes, layout: _Layout) -> FloatArray:
    """Unpack LZF; the fields then stand one after the other, each for all points."""
    if len(body) < 8:
        raise _cut_short(layout)
    packed_size, size = struct.unpack_from("<2I", body)
    if len(body) < 8 + packed_size or size != layout.point_count * layout.record.itemsize:
        raise _cut_short(layout)
    unpacked = _lzf(body[8 : 8 + packed_size], size)
    start, columns = 0, {}
    for name in layout.record.names or ():
        kind = layout.record[name]
        if name in ("x", "y", "z"):
            columns[name] = np.frombuffer(unpacked, kind.base, layout.point_count, start)
        start += layout.point_count * kind.itemsize
    return np.stack([columns[axis] for axis in "xyz"], axis=1).astype(np.float64)


def _lzf(packed: bytes, size: int) -> bytes:
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
        raise FormatError("has damaged compressed data; export it again") from error
    if len(out) != size:
        raise FormatError(
            f"has compressed data of {len(out):,} bytes instead of {size:,}; it is damaged: export it again"
        )
    return bytes(out)


def _cut_short(layout: _Layout) -> FormatError:
    return FormatError(
        f"announces {layout.point_count:,} points, but ends before them; it was cut short: copy or export it "
        "again"
    )
