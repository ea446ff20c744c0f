# SPDX-License-Identifier: MIT
"""Reading Wavefront OBJ: positions and faces, many lines at a time.

Not left to trimesh, which in version 5.2 reads other geometry than the file's where lines are indented or
tabbed, or indices are relative or 0, and splits vertices at texture seams.
"""

from __future__ import annotations

import re
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, check_face_count
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import parse_corners, parse_numbers, plain_text, unexpected

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
    vertices = parse_numbers(vertex_lines, (1, 2, 3), _EXPECTED)
    if not face_lines:
        return Polygons.from_points(vertices)
    sizes = np.fromiter((line.count(b" ") for line in face_lines), np.int64, len(face_lines))
    corners = _corners(face_lines, sizes)
    if (corners < 0).any():
        corners = _absolute(corners, sizes, lines)
    else:
        corners -= 1
    missing = corners[(corners >= len(vertices)) & np.repeat(sizes > 2, sizes)]
    if missing.size:
        raise DamagedError(
            f"has a face that names vertex {missing.max() + 1}, but there are only {len(vertices):,}"
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


def _corners(lines: list[bytes], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Vertices of all faces one after the other, as they are written; without texture and normals."""
    text = b"\n".join(lines)
    plain = re.sub(rb"/\S*", b"", text).split(b"\n") if b"/" in text else lines
    with suppress(FormatError):  # which would quote the line without what was cut off
        corners = parse_corners(plain, 1, sizes)
        if corners.all():
            return corners
    wrong = next((line for line in lines if not _SOUND_FACE.fullmatch(line)), lines[-1])
    raise unexpected(wrong, _EXPECTED)


def _absolute(corners: NDArray[np.int64], sizes: NDArray[np.int64], lines: list[bytes]) -> NDArray[np.int64]:
    """Corners counted from 0; negative ones count back from the vertices that stand above their face."""
    above = np.cumsum([line.startswith(b"v ") for line in lines])[[line.startswith(b"f ") for line in lines]]
    counted = np.where(corners < 0, corners + np.repeat(above, sizes), corners - 1)
    if (counted < 0).any():
        first = int(np.argmax(counted < 0))
        raise DamagedError(
            f"names vertex {corners[first]}, but only {np.repeat(above, sizes)[first]} stand above"
        )
    return counted
