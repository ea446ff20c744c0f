# SPDX-License-Identifier: MIT
"""Reading Wavefront OBJ: positions and faces, many lines at a time.

Not left to trimesh, which in version 5.2 reads other geometry than the file's where lines are indented or
tabbed, indices are relative or 0, and splits vertices at texture seams. Rewriting the lines as it reads them
right took five times as long as reading all numbers at once.
"""

from __future__ import annotations

import re
import warnings

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.ply import FormatError, check_face_count
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["read_obj"]

_BLANKS = bytes.maketrans(b"\t\r\f\v", b"    ")
_SOUND_FACE = re.compile(rb"f(?: [-+]?0*[1-9]\d*(?:/\S*)?)+")


def read_obj(data: bytes, max_faces: int) -> tuple[FloatArray, NDArray[np.int64]]:
    """Read vertices and faces of all objects and groups.

    Parameters
    ----------
    data : bytes
        Of the file.
    max_faces : int
        So many triangles at most.

    Returns
    -------
    vertices : (n, 3) array
    triangles : (m, 3) array of int
        Polygons are fans of triangles.

    Raises
    ------
    FormatError
        If a line is damaged, a face names a vertex that is not there, or there are too many faces.
    """
    lines = _plain_lines(data)
    vertex_lines = [line for line in lines if line.startswith(b"v ")]
    face_lines = [line for line in lines if line.startswith(b"f ")]
    check_face_count(len(face_lines), max_faces)
    for cut_short in (b"v", b"f"):
        if cut_short in lines:
            raise _damaged(cut_short)
    if not vertex_lines:
        raise FormatError("has no vertex lines: it is empty, or no OBJ file; export it again")
    vertices = _positions(vertex_lines)
    if not face_lines:
        return vertices, np.empty((0, 3), np.int64)
    sizes = np.fromiter((line.count(b" ") for line in face_lines), np.int64, len(face_lines))
    check_face_count(int(np.maximum(sizes - 2, 0).sum()), max_faces)
    corners = _corners(face_lines, int(sizes.sum()))
    if (corners < 0).any():
        corners = _absolute(corners, sizes, lines)
    else:
        corners -= 1
    triangles = _fans(corners, sizes)
    if triangles.size and triangles.max() >= len(vertices):
        raise FormatError(
            f"has a face that names vertex {triangles.max() + 1}, but there are only {len(vertices):,}; "
            "it is damaged or was cut short"
        )
    return vertices, triangles


def _plain_lines(data: bytes) -> list[bytes]:
    """Lines without comments and continuations, with single blanks and none at their ends."""
    # A replacement that finds nothing costs next to nothing; a regular expression does.
    text = re.sub(rb"#.*", b"", data) if b"#" in data else data
    text = re.sub(rb"\\\r?\n", b" ", text) if b"\\" in text else text
    text = text.translate(_BLANKS)
    while b"  " in text:
        text = text.replace(b"  ", b" ")
    return text.replace(b" \n", b"\n").replace(b"\n ", b"\n").strip().split(b"\n")


def _damaged(line: bytes) -> FormatError:
    return FormatError(
        f"has a line {line[:60].decode('latin-1')!r} that cannot be read; it is damaged or was cut short: "
        "copy or export it again"
    )


def _numbers(text: bytes, kind: type[np.generic]) -> NDArray[np.generic]:
    """Numbers with blanks between them; none at all if something else is there."""
    with warnings.catch_warnings():
        # numpy before 2.4 only warns of what it cannot read, and leaves the rest out.
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, kind, sep=" ")
        except (ValueError, DeprecationWarning):
            return np.empty(0, kind)


def _positions(lines: list[bytes]) -> FloatArray:
    """First three numbers of each line; what follows is a weight, or a colour."""
    columns = {line.count(b" ") for line in lines}
    if len(columns) == 1 and min(columns) >= 3:
        numbers = _numbers(b"".join(lines).replace(b"v", b" "), np.float64)
        if numbers.size == len(lines) * min(columns):
            return np.ascontiguousarray(numbers.reshape(len(lines), -1)[:, :3], np.float64)
    positions = np.empty((len(lines), 3))
    for index, line in enumerate(lines):
        try:
            x, y, z = line.split(b" ", 4)[1:4]
            positions[index] = float(x), float(y), float(z)
        except ValueError as error:
            raise _damaged(line) from error
    return positions


def _corners(lines: list[bytes], count: int) -> NDArray[np.int64]:
    """Vertices of all faces one after the other, as they are written; without texture and normals."""
    text = b" ".join(lines)
    if b"/" in text:
        text = re.sub(rb"/\S*", b"", text)
    corners = np.asarray(_numbers(text.replace(b"f", b""), np.int64), np.int64)
    if corners.size != count or not corners.all():
        raise _damaged(next((line for line in lines if not _SOUND_FACE.fullmatch(line)), lines[-1]))
    return corners


def _absolute(corners: NDArray[np.int64], sizes: NDArray[np.int64], lines: list[bytes]) -> NDArray[np.int64]:
    """Corners counted from 0; negative ones count back from the vertices that stand above their face."""
    above = np.cumsum([line.startswith(b"v ") for line in lines])[[line.startswith(b"f ") for line in lines]]
    counted = np.where(corners < 0, corners + np.repeat(above, sizes), corners - 1)
    if (counted < 0).any():
        first = int(np.argmax(counted < 0))
        raise FormatError(
            f"names vertex {corners[first]}, but only {np.repeat(above, sizes)[first]} stand above"
        )
    return counted


def _fans(corners: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles of polygons of so many corners each; fewer than three are a point or a line.

    Simplifying a mesh depends on the order of its triangles: this is trimesh's, with which models were made.
    """
    starts = np.cumsum(sizes) - sizes
    if (sizes == sizes[0]).all() and sizes[0] in (3, 4):
        rows = corners.reshape(len(sizes), -1)
        return rows if sizes[0] == 3 else np.concatenate([rows[:, [0, 1, 2]], rows[:, [2, 3, 0]]])
    counts = np.maximum(sizes - 2, 0)
    places = np.cumsum(counts) - counts
    triangles = np.empty((int(counts.sum()), 3), np.int64)
    for size in np.unique(sizes[sizes > 2]).tolist():
        fan = np.array([[0, corner, corner + 1] for corner in range(1, size - 1)])
        if size == 4:
            fan[1] = 2, 3, 0
        chosen = sizes == size
        rows = corners[starts[chosen, None] + np.arange(size)]
        triangles[places[chosen, None] + np.arange(size - 2)] = rows[:, fan]
    return triangles
