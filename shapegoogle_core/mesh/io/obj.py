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
from shapegoogle_core.mesh.io.numbers import parse_corners, parse_numbers
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import Lines, lines_of, plain_text, quoted, unexpected
from shapegoogle_core.mesh.mesh import counted

__all__ = ["read_obj"]

_BLANKS = bytes.maketrans(b"\t\f\v", b"   ")
# Words at the beginning of a line, also of what is not read: normals, materials, free-form surfaces.
_WORDS = frozenset(
    b"v vt vn vp f l p o g s mg usemtl mtllib usemap maplib shadow_obj trace_obj bevel c_interp d_interp lod "
    b"ctech stech cstype deg bmat step curv curv2 surf parm trim hole scrv sp end con res".split()
) | {b""}
_LETTERS = 3
_BEGINNINGS = frozenset(word[:_LETTERS] for word in _WORDS if len(word) >= _LETTERS)
_A_VERTEX = "a vertex (v and three coordinates)"
_A_FACE = "a face (f and the vertices, counted from 1, or from the last one with -1)"
_SOUND_FACE = re.compile(rb"f(?: [-+]?0*[1-9]\d*(?:\.0*)?(?:/\S*)?)+")
_CONTINUED = re.compile(rb"(?:[^\n]*\\[ ]*\n)+[^\n]*")


def read_obj(file: MeshFile) -> Polygons:
    """Read vertices and faces of all objects and groups.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    polygons : Polygons
        With a note if there are free-form surfaces, which are left out. Lines and points are no surface.

    Raises
    ------
    FormatError
        If a line is damaged, a face names a vertex that is not there, or there are too many faces.
    """
    lines = _plain_lines(file.data)
    vertex_lines = _beginning_with(b"v", lines)
    face_lines = _beginning_with(b"f", lines)
    check_face_count(len(face_lines), file.max_faces)
    for cut_short, expected in ((b"v", _A_VERTEX), (b"f", _A_FACE)):
        if cut_short in lines:
            raise unexpected(cut_short, lines.index(cut_short) + 1, expected)
    if not len(vertex_lines):
        raise FormatError("has no vertex lines: it is empty, or not an OBJ file; export it again")
    vertices = parse_numbers(vertex_lines, (1, 2, 3), _A_VERTEX)
    others = len(vertex_lines) + len(face_lines) + lines.count(b"") < len(lines)
    surfaces, unknown = _left_out(lines) if others else (0, ())
    if not len(face_lines):
        if surfaces:
            raise FormatError(
                "has only free-form surfaces (surf), which cannot be read; export it with polygons (f)"
            )
        return Polygons.from_points(vertices)
    sizes = np.fromiter((line.count(b" ") for line in face_lines.content), np.int64, len(face_lines))
    corners = _corners(face_lines, sizes)
    if (corners < 0).any():
        corners = _absolute(corners, sizes, vertex_lines, face_lines)
    else:
        corners -= 1
    missing = np.flatnonzero((corners >= len(vertices)) & np.repeat(sizes > 2, sizes))
    if len(missing):
        number = face_lines.numbers[_face_of(int(missing[0]), sizes)]
        raise DamagedError(
            f"names vertex {corners[missing[0]] + 1} in line {number:,}, but there are only {len(vertices):,}"
        )
    notes = list(unknown)
    if surfaces:
        free_form = counted(surfaces, "free-form surface", "free-form surfaces")
        notes.append(f"has {free_form} (surf), which cannot be read; convert them to polygons")
    return Polygons(vertices, corners, sizes, tuple(notes))


def _left_out(lines: list[bytes]) -> tuple[int, tuple[str, ...]]:
    """Count free-form surfaces, and note lines that begin with no word of the format.

    Damage may hide vertices or faces in such a line.
    """
    # The first letters of a line are one of a few hundred strings; the words themselves would take long.
    beginnings = {line[:_LETTERS] for line in lines}
    surfaces = sum(line.startswith(b"surf ") for line in lines) if b"sur" in beginnings else 0
    unknown = {each for each in beginnings - _BEGINNINGS if each.split(b" ")[0] not in _WORDS}
    if not unknown:
        return surfaces, ()
    numbers = [number for number, line in enumerate(lines, 1) if line[:_LETTERS] in unknown]
    first = f"{quoted(lines[numbers[0] - 1])} in line {numbers[0]:,}"
    return surfaces, (
        f"has {lines_of(len(numbers))} of an unknown kind (first: {first}); they were not read",
    )


def _plain_lines(data: bytes) -> list[bytes]:
    """Lines without comments and continuations, with single blanks and none at their ends.

    There are as many as in the file, so that errors can name them.
    """
    # A replacement that finds nothing costs next to nothing; a regular expression does.
    text = plain_text(data)
    text = re.sub(rb"#.*", b"", text) if b"#" in text else text
    text = _CONTINUED.sub(_joined, text) if b"\\" in text else text
    text = text.translate(_BLANKS)
    while b"  " in text:
        text = text.replace(b"  ", b" ")
    return text.replace(b" \n", b"\n").replace(b"\n ", b"\n").strip(b" ").split(b"\n")


def _joined(match: re.Match[bytes]) -> bytes:
    parts = match[0].split(b"\n")
    return b" ".join(part.rstrip().removesuffix(b"\\") for part in parts) + b"\n" * (len(parts) - 1)


def _beginning_with(word: bytes, lines: list[bytes]) -> Lines:
    start = word + b" "
    return Lines(
        [line for line in lines if line.startswith(start)],
        lambda: [number for number, line in enumerate(lines, 1) if line.startswith(start)],
    )


def _corners(lines: Lines, sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Vertices of all faces one after the other, as they are written; without texture and normals."""
    text = b"\n".join(lines.content)
    plain = re.sub(rb"/\S*", b"", text).split(b"\n") if b"/" in text else lines.content
    with suppress(FormatError):  # which would quote the line without what was cut off
        corners = parse_corners(lines.with_content(plain), 1, sizes)
        if corners.all():
            return corners
    wrong = (place for place, line in enumerate(lines.content) if not _SOUND_FACE.fullmatch(line))
    raise lines.unexpected(next(wrong, 0), _A_FACE)


def _absolute(
    corners: NDArray[np.int64], sizes: NDArray[np.int64], vertex_lines: Lines, face_lines: Lines
) -> NDArray[np.int64]:
    """Corners counted from 0; negative ones count back from the vertices that stand above their face."""
    above = np.searchsorted(vertex_lines.numbers, face_lines.numbers)
    counted = np.where(corners < 0, corners + np.repeat(above, sizes), corners - 1)
    if (counted < 0).any():
        first = int(np.argmax(counted < 0))
        face = _face_of(first, sizes)
        raise DamagedError(
            f"names vertex {corners[first]} in line {face_lines.numbers[face]:,}, "
            f"but only {above[face]:,} stand above"
        )
    return counted


def _face_of(corner: int, sizes: NDArray[np.int64]) -> int:
    return int(np.searchsorted(np.cumsum(sizes), corner, "right"))
