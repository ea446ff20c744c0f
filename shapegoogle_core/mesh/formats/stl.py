# SPDX-License-Identifier: MIT
"""STL, binary and text: three vertices of its own for every triangle."""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np

from shapegoogle_core.mesh.formats.common import (
    FormatError,
    Geometry,
    check_face_count,
    file_size,
    lines_of,
    points_of,
)

__all__ = ["read_stl"]

_HEADER_BYTES = 84
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(path: Path, max_faces: int) -> Geometry:
    """Read an STL file; binary if its length fits the count in its header.

    Parameters
    ----------
    path : Path
    max_faces : int

    Returns
    -------
    vertices : (3m, 3) array
    faces : (m, 3) array

    Raises
    ------
    FormatError
    """
    size = file_size(path)
    with path.open("rb") as file:
        header = file.read(_HEADER_BYTES)
        count = int.from_bytes(header[80:84], "little")
        if len(header) == _HEADER_BYTES and size == _HEADER_BYTES + count * _TRIANGLE.itemsize:
            check_face_count(count, max_faces)
            corners = np.fromfile(file, _TRIANGLE, count)["corners"]
            if len(corners) < count:
                raise FormatError("became shorter while it was read; read it again")
            vertices = corners.astype(np.float64).reshape(-1, 3)
            return vertices, np.arange(len(vertices)).reshape(-1, 3)
    if header.lstrip()[:5].lower() == b"solid":
        return _read_text(path, max_faces)
    if len(header) < _HEADER_BYTES:
        raise FormatError(f"has only {size} bytes, which is no STL file; copy or export it again")
    raise FormatError(
        f"claims {count:,} triangles, which take {_HEADER_BYTES + count * _TRIANGLE.itemsize:,} bytes, but "
        f"has {size:,}; it is no STL file, damaged or cut short: copy or export it again"
    )


def _read_text(path: Path, max_faces: int) -> Geometry:
    coordinates = array("d")
    last_end = 0
    ended = False
    with path.open("rb") as file:
        for number, words in lines_of(file, comment=b""):
            keyword = words[0].lower()
            if keyword == b"vertex":
                try:
                    if len(words) != 4:
                        raise ValueError("a vertex has three coordinates")
                    coordinates.extend(map(float, words[1:]))
                except ValueError as error:
                    raise FormatError(
                        f"has a line {number} that cannot be read ({error}); it is damaged or was cut short"
                    ) from error
            elif keyword == b"endfacet":
                if len(coordinates) != last_end + 9:
                    raise FormatError(f"has a facet that is no triangle before line {number}; it is damaged")
                last_end = len(coordinates)
                check_face_count(last_end // 9, max_faces)
            ended = keyword == b"endsolid" or (keyword == b"end" and words[1:2] == [b"solid"])
    if not ended or len(coordinates) != last_end:
        raise FormatError("ends before the word endsolid: it was cut short; copy or export it again")
    vertices = points_of(coordinates)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)
