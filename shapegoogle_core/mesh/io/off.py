# SPDX-License-Identifier: MIT
"""Reading OFF: a text of counts, vertices and polygons, usually one a line."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, check_face_count
from shapegoogle_core.mesh.io.numbers import parse_numbers, parse_polygons, word_numbers
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import Lines, filled_lines, lines_of, plain_text, unexpected
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["read_off"]

_WORD = re.compile(rb"\s*(ST)?(C)?(N)?(4)?(n)?(?:OFF|off)(?![^\d\s])(?:[ \t]+(BINARY)\b)?")
# Some files of the Princeton and ModelNet collections have "OFF3514 3546 0" in one line. The number of edges,
# which nobody needs, may be left out.
_COUNTS = re.compile(rb"\s*(\d+)\s+(\d+)(?:[ \t]+\d+|\s*\n[ \t]*\d+(?=[ \t]*\n))?[ \t]*(?=\n|\Z)")
_A_VERTEX = "a vertex (three coordinates)"


def read_off(file: MeshFile) -> Polygons:
    """Read an OFF file, also one with colours, normals or texture coordinates.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    polygons : Polygons

    Raises
    ------
    FormatError
        If the counts do not fit the file, a line is damaged, or there are too many faces.
    """
    text = plain_text(file.data)
    text = re.sub(rb"#.*", b"", text) if b"#" in text else text
    word = _WORD.match(text)
    head = _COUNTS.match(text, word.end() if word else 0)
    if word is None and head is None:
        raise FormatError(
            "does not begin with the word OFF: it is empty, or not an OFF file; export it again"
        )
    texture, colour, normal, homogeneous, dimensions, binary = word.groups() if word else (None,) * 6
    if binary:
        raise FormatError("is a binary OFF file, which cannot be read; export it as text")
    if dimensions:
        raise FormatError(
            "has vertices of any number of dimensions (nOFF), which cannot be read; export it again"
        )
    if head is None:
        start = len(text) - len(text[word.end() if word else 0 :].lstrip())
        if start == len(text):
            raise DamagedError("ends after the word OFF")
        raise unexpected(
            text[start:].partition(b"\n")[0],
            text.count(b"\n", 0, start) + 1,
            "a line with the counts of vertices, faces and edges",
        )
    vertex_count, face_count = int(head[1]), int(head[2])
    if 2 * (vertex_count + face_count) > len(text):
        raise DamagedError(
            f"claims {vertex_count:,} vertices and {face_count:,} faces in {len(file.data):,} bytes"
        )
    check_face_count(face_count, file.max_faces)
    lines = filled_lines(text[head.end() :], text.count(b"\n", 0, head.end()) + 1)
    width = 4 if homogeneous else 3
    more = (3 if normal else 0) + (2 if texture else 0)
    widths = [width + more + channels for channels in ((3, 4) if colour else (0,))]
    polygons = _parse(lines, vertex_count, face_count, width, widths)
    if not homogeneous:
        return polygons
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return replace(polygons, vertices=polygons.vertices[:, :3] / polygons.vertices[:, 3:])


def _parse(lines: Lines, vertex_count: int, face_count: int, width: int, widths: list[int]) -> Polygons:
    """Parse one vertex or face a line, unless only another division into lines fits the counts."""
    count = vertex_count + face_count
    try:
        found = lines.first(count)
        vertices = parse_numbers(found.part(0, vertex_count), range(width), _A_VERTEX)
        polygons = Polygons(vertices, *parse_polygons(found.part(vertex_count), 0, vertex_count))
    except FormatError:
        wrapped = _parse_wrapped(lines, vertex_count, face_count, width, widths)
        if wrapped is None:
            raise
        return wrapped
    if len(lines) == count:
        return polygons
    wrapped = _parse_wrapped(lines, vertex_count, face_count, width, widths)
    more = f"{lines_of(len(lines) - count)} behind the {face_count:,} faces that it announces"
    note = f"has {more}; they were not read"
    return wrapped or replace(polygons, notes=(note,))


def _parse_wrapped(
    lines: Lines, vertex_count: int, face_count: int, width: int, widths: list[int]
) -> Polygons | None:
    """Parse vertices and faces as one sequence of numbers, if it has exactly as many in one reading."""
    try:
        numbers = word_numbers(lines, "a number")
    except FormatError:
        return None
    readings = []
    for each in widths:
        vertices = numbers[: vertex_count * each]
        faces = _polygons(numbers[vertex_count * each :], face_count, vertex_count)
        if faces is not None:
            readings.append(Polygons(vertices.reshape(vertex_count, each)[:, :width], *faces))
    return readings[0] if len(readings) == 1 else None


def _polygons(
    numbers: FloatArray, face_count: int, vertex_count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Divide a sequence of sizes, each followed by as many vertices; None if it is not one."""
    if not ((numbers >= 0) & (numbers == np.floor(numbers)) & (numbers < 2**31)).all():
        return None
    whole = numbers.astype(np.int64).tolist()
    corners, sizes, place = list[int](), list[int](), 0
    for _ in range(face_count):
        if place >= len(whole):
            return None
        size = whole[place]
        sizes.append(size)
        corners += whole[place + 1 : place + 1 + size]
        place += 1 + size
    if place != len(whole) or max(corners, default=0) >= vertex_count:
        return None
    return np.array(corners, np.int64), np.array(sizes, np.int64)
