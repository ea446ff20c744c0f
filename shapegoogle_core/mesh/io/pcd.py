# SPDX-License-Identifier: MIT
"""Files of scanners that hold points and no faces: XYZ texts and the PCD files of the Point Cloud Library."""

from __future__ import annotations

import io
import re
import struct
from typing import NamedTuple

import numpy as np

from shapegoogle_core.mesh.io.ply import FormatError
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["check_point_count", "read_pcd", "read_xyz"]

_PCD_TYPES = {"F": "f", "I": "i", "U": "u"}
_PCD_SIZES = (1, 2, 4, 8)


def check_point_count(count: int, most: int) -> None:
    """Raise `FormatError` if there are more points than wanted."""
    if count > most:
        raise FormatError(
            f"has {count:,} points, above the limit of {most:,}; thin it first, or raise max_faces"
        )


def read_xyz(data: bytes, most: int) -> FloatArray:
    """Read the first three numbers of each line; what follows (normals, colours) is left out.

    Blanks, tabs, commas or semicolons stand between them. Comments begin with # or //; a first line that
    names the columns x, y, z is one.

    Parameters
    ----------
    data : bytes
    most : int
        So many points at most.

    Returns
    -------
    points : (n, 3) array

    Raises
    ------
    FormatError
        If a line is no point, or there are too many.
    """
    text = re.sub(rb"[,;]", b" ", re.sub(rb"(#|//).*", b"", data))
    text = re.sub(rb"\A\s*x\s+y\s+z\b.*", b"", text, flags=re.IGNORECASE)
    if not text.strip():
        raise FormatError("has no points: it is empty, or no XYZ file; export it again")
    check_point_count(sum(1 for _ in re.finditer(rb"\S.*", text)), most)
    try:
        points = np.loadtxt(io.BytesIO(text), usecols=(0, 1, 2), ndmin=2, encoding="latin-1")
    except ValueError as error:
        reason = str(error).partition(";")[0]
        raise FormatError(
            f"has a line that is no point ({reason}); it is damaged, cut short or no XYZ file: export it"
        ) from error
    return np.asarray(points, np.float64)


class _Layout(NamedTuple):
    """What a PCD header says: one record for each point, and how the data are written."""

    record: np.dtype[np.void]
    point_count: int
    encoding: str


def read_pcd(data: bytes, most: int) -> FloatArray:
    """Read the positions of a PCD file, version 0.7 or before: text, binary or compressed.

    Points without a position (NaN), which stand for rays that met nothing, are left out.

    Parameters
    ----------
    data : bytes
    most : int
        So many points at most.

    Returns
    -------
    points : (n, 3) array

    Raises
    ------
    FormatError
        If the header or the data are damaged, or there are too many points.
    """
    header = re.search(rb"^DATA[ \t]+(\w+)[ \t\r]*(\n|\Z)", data[: 1 << 16], re.MULTILINE)
    if header is None:
        raise FormatError("has no PCD header with a line DATA; it is no PCD file or was cut short")
    layout = _pcd_layout(data[: header.start()].decode("latin-1"), header[1].decode())
    check_point_count(layout.point_count, most)
    body = data[header.end() :]
    if layout.encoding == "ascii":
        points = _pcd_text(body, layout)
    elif layout.encoding == "binary":
        if len(body) < layout.point_count * layout.record.itemsize:
            raise _cut_short(layout)
        points = _positions(np.frombuffer(body, layout.record, layout.point_count))
    elif layout.encoding == "binary_compressed":
        points = _pcd_compressed(body, layout)
    else:
        raise FormatError(f"has the unknown kind of data {layout.encoding!r}; export it again")
    measured: FloatArray = points[~np.isnan(points).all(axis=1)]
    return measured


def _pcd_layout(header: str, encoding: str) -> _Layout:
    values = {}
    for line in header.splitlines():
        if words := line.partition("#")[0].split():
            values[words[0].upper()] = words[1:]
    try:
        names = [name.lower() for name in values["FIELDS"]]
        sizes, counts = map(int, values["SIZE"]), map(int, values.get("COUNT", ["1"] * len(names)))
        fields = []
        for name, size, kind, count in zip(names, sizes, values["TYPE"], counts, strict=True):
            if size not in _PCD_SIZES or not 0 <= count < 1 << 16:
                raise ValueError(f"{count} values of {size} bytes")
            fields.append((name, f"<{_PCD_TYPES[kind]}{size}", (count,)))
        width, height = (int(values[name][0]) for name in ("WIDTH", "HEIGHT"))
        count = int(values["POINTS"][0]) if "POINTS" in values else width * height
        # Names may repeat ("_" is filler), so records have numbers instead.
        place = [names.index(axis) for axis in "xyz"]
        titles = {index: axis for axis, index in zip("xyz", place, strict=True)}
        renamed = [(titles.get(index, f"f{index}"), *rest) for index, (_, *rest) in enumerate(fields)]
        record = np.dtype([(name, kind, shape) for name, kind, shape in renamed if shape != (0,)])
        if count < 0 or any(record[axis].shape != (1,) for axis in "xyz"):
            raise ValueError(f"{count} points, positions of shape {record['x'].shape}")
    except (KeyError, ValueError, IndexError, TypeError) as error:
        raise FormatError(f"has a damaged PCD header ({error}); export it again") from error
    return _Layout(record, count, encoding)


def _positions(records: np.ndarray[tuple[int], np.dtype[np.void]]) -> FloatArray:
    return np.concatenate([records[axis] for axis in "xyz"], axis=1).astype(np.float64)


def _pcd_text(body: bytes, layout: _Layout) -> FloatArray:
    column, place = 0, {}
    for name in layout.record.names or ():
        place[name] = column
        column += layout.record[name].shape[0]
    try:
        rows = np.loadtxt(
            io.BytesIO(body),
            usecols=[place[axis] for axis in "xyz"],
            ndmin=2,
            max_rows=max(layout.point_count, 1),
        )
    except ValueError as error:
        reason = str(error).partition(";")[0]
        raise FormatError(
            f"has a line that is no point ({reason}); it is damaged: export it again"
        ) from error
    if len(rows) < layout.point_count:
        raise _cut_short(layout)
    return np.asarray(rows[: layout.point_count], np.float64)


def _pcd_compressed(body: bytes, layout: _Layout) -> FloatArray:
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
    """Unpack what LibLZF packed: runs of bytes as they are, and references to what came before."""
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
                raise IndexError("a reference to before the beginning")
            if start + length <= len(out):
                out += out[start : start + length]
            else:  # it runs into what it writes: a repeated pattern
                pattern = bytes(out[start:])
                out += (pattern * (length // len(pattern) + 1))[:length]
            if len(out) > size:
                break
    except IndexError as error:
        raise FormatError(f"has damaged compressed data ({error}); export it again") from error
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
