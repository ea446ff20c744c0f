# SPDX-License-Identifier: MIT
"""Reading Wavefront OBJ: positions and faces, many lines at a time.

Not left to trimesh, which in version 5.2 reads other geometry than the file's where lines are indented or
tabbed, or indices are relative or 0, and splits vertices at texture seams.
"""

from __future__ import annotations

import re
import warnings

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import FormatError, MeshFile, check_face_count
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import parse_numbers, plain_text, unexpected
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["read_obj"]

_BLANKS = bytes.maketrans(b"\t\f\v", b"   ")
_EXPECTED = "a vertex or a face"
_SOUND_FACE = re.compile(rb"f(?: [-+]?0*[1-9]\d*(?:/\S*)?)+")


def read_obj(file: MeshFile) -> Polygons:
    """Read vertices and faces of all objects and groups.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    polygons : Polygons

    Raises
    ------
    FormatError
        If a line is damaged, a face names a vertex that is not there, or there are too many faces.
    """
    lines = _plain_lines(file.data)
    vertex_lines = [line for line in lines if line.startswith(b"v ")]
    face_lines = [line for line in lines if line.startswith(b"f ")]
    check_face_count(len(face_lines), file.max_faces)
    for cut_short in (b"v", b"f"):
        if cut_short in lines:
            raise unexpected(cut_short, _EXPECTED)
    if not vertex_lines:
        raise FormatError("has no vertex lines: it is empty, or not an OBJ file; export it again")
    vertices = _positions(vertex_lines)
    if not face_lines:
        return Polygons.from_points(vertices)
    sizes = np.fromiter((line.count(b" ") for line in face_lines), np.int64, len(face_lines))
    corners = _corners(face_lines, int(sizes.sum()))
    if (corners < 0).any():
        corners = _absolute(corners, sizes, lines)
    else:
        corners -= 1
    missing = corners[(corners >= len(vertices)) & np.repeat(sizes > 2, sizes)]
    if missing.size:
        raise FormatError(
            f"has a face that names vertex {missing.max() + 1}, but there are only {len(vertices):,}; "
            "it is damaged or was cut short"
        )
    return Polygons(vertices, corners, sizes)


def _plain_lines(data: bytes) -> list[bytes]:
    """Lines without comments and continuations, with single blanks and none at their ends."""
    # A replacement that finds nothing costs next to nothing; a regular expression does.
    text = plain_text(data)
    text = re.sub(rb"#.*", b"", text) if b"#" in text else text
    text = re.sub(rb"\\\n", b" ", text) if b"\\" in text else text
    text = text.translate(_BLANKS)
    while b"  " in text:
        text = text.replace(b"  ", b" ")
    return text.replace(b" \n", b"\n").replace(b"\n ", b"\n").strip().split(b"\n")


def _numbers(text: bytes, kind: type[np.generic]) -> NDArray[np.generic]:
    """Numbers with blanks between them; an empty array if there is anything else."""
    with warnings.catch_warnings():
        # numpy before 2.4 only warns of text that is not a number, and leaves out the rest.
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, kind, sep=" ")
        except (ValueError, DeprecationWarning):
            return np.empty(0, kind)


def _positions(lines: list[bytes]) -> FloatArray:
    """First three numbers of each line; a weight or a colour may follow."""
    columns = {line.count(b" ") for line in lines}
    if len(columns) == 1 and min(columns) >= 3:
        numbers = _numbers(b"".join(lines).replace(b"v", b" "), np.float64)
        if numbers.size == len(lines) * min(columns):
            return np.ascontiguousarray(numbers.reshape(len(lines), -1)[:, :3], np.float64)
    return parse_numbers(lines, (1, 2, 3), _EXPECTED)


def _corners(lines: list[bytes], count: int) -> NDArray[np.int64]:
    """Vertices of all faces one after the other, as they are written; without texture and normals."""
    text = b" ".join(lines)
    if b"/" in text:
        text = re.sub(rb"/\S*", b"", text)
    corners = np.asarray(_numbers(text.replace(b"f", b""), np.int64), np.int64)
    if corners.size != count or not corners.all():
        wrong = next((line for line in lines if not _SOUND_FACE.fullmatch(line)), lines[-1])
        raise unexpected(wrong, _EXPECTED)
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
