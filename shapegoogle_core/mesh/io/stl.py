# SPDX-License-Identifier: MIT
"""Reading STL, binary and text: triangles with three vertices of their own each."""

from __future__ import annotations

import re

import numpy as np

from shapegoogle_core.mesh.io.file import DamagedError, MeshFile, check_face_count
from shapegoogle_core.mesh.io.numbers import NUMBER, parse_numbers
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import Lines, plain_text, unexpected
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["read_stl"]

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER_SIZE = 84
_LINE_END = b"\n"
_FACET = re.compile(rb"\bvertex((?:[ \t]+[-+.,\w]+){3})\s+" * 3 + rb"end")
# The name of a solid, which goes on to the end of the line or, in a file of one line, to the first facet.
_NAMED = re.compile(rb"^[ \t]*(end ?)?solid\b.*?(?=\bfacet[ \t]+normal\b|$)", re.MULTILINE)
_END_BEHIND_FACET = re.compile(rb"(?<=endfacet)[ \t]+(?=end ?solid\b)")
_A_VERTEX = "a vertex (the word and three coordinates)"
# The first words of the lines of a facet, in their order, and what they stand for.
_LINES = (
    (b"facet", "a facet or the word endsolid"),
    (b"outer", "an outer loop"),
    *3 * ((b"vertex", _A_VERTEX),),
    (b"endloop", "the word endloop"),
    (b"endfacet", "the word endfacet"),
)


def read_stl(file: MeshFile) -> Polygons:
    """Read an STL file; the solids of a text become one mesh.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    polygons : Polygons
        Not welded: vertices 3i, 3i + 1 and 3i + 2 are the corners of triangle i.

    Raises
    ------
    FormatError
        If the file ends before the triangles that it announces, a facet of a text is not a triangle, or there
        are too many faces.
    """
    data = file.data
    text = _text(data)
    if text is not None:
        return _triangles(_text_vertices(text, file.max_faces), ())
    if len(data) < _HEADER_SIZE:
        raise DamagedError(
            f"has {len(data)} bytes, less than the header of a binary STL ({_HEADER_SIZE}), "
            "and does not begin with the word solid of a text"
        )
    count = int.from_bytes(data[80:_HEADER_SIZE], "little")
    size = _HEADER_SIZE + _RECORD.itemsize * count
    if len(data) < size:
        raise DamagedError(
            f"announces {count:,} triangles at byte 80, which take {size:,} bytes, but has {len(data):,} "
            "bytes, or is not an STL file"
        )
    check_face_count(count, file.max_faces)
    with np.errstate(invalid="ignore"):  # some kinds of NaN
        corners = np.frombuffer(data, _RECORD, count, _HEADER_SIZE)["corners"]
        vertices = corners.reshape(-1, 3).astype(np.float64)
    more = len(data) - size
    if not count and more >= _RECORD.itemsize:
        raise DamagedError(f"announces 0 triangles at byte 80, but {more:,} bytes follow")
    # Some programs write a colour table or a checksum behind the triangles.
    note = f"has {more:,} bytes behind the {count:,} triangles that it announces; they were not read"
    return _triangles(vertices, (note,) if more >= _RECORD.itemsize else ())


def _text(data: bytes) -> bytes | None:
    """Decode an STL in text form; None if it is binary, which may begin with the word solid too."""
    beginning = data[:_HEADER_SIZE]
    if plain_text(beginning).lstrip()[:5].lower() != b"solid":
        return None
    size = _HEADER_SIZE + _RECORD.itemsize * int.from_bytes(data[80:_HEADER_SIZE], "little")
    # The letters of a text, read as the count, announce more triangles than any file holds.
    if len(beginning) == _HEADER_SIZE and size <= len(data) and beginning[:5].lower() == b"solid":
        return None
    return plain_text(data).lower()


def _text_vertices(text: bytes, max_faces: int) -> FloatArray:
    if b"endfacet endsolid" in text:  # everything in one line
        text = _END_BEHIND_FACET.sub(b"\n", text)
    text = _NAMED.sub(rb"\1solid ", text)  # names say anything
    if not re.search(rb"\bend ?solid\s*\Z", text):
        raise _wrong_line(text) or DamagedError(
            f"ends in line {text.count(_LINE_END) + 1:,} before the word endsolid"
        )
    facet_count = text.count(b"endfacet")
    check_face_count(facet_count, max_faces)
    triangles = _FACET.findall(text)
    if not 3 * len(triangles) == 3 * facet_count == text.count(b"vertex"):
        raise _wrong_line(text) or DamagedError(
            f"has {facet_count:,} facets, of which {len(triangles):,} are triangles"
        )
    lines = [vertex for triangle in triangles for vertex in triangle]
    return parse_numbers(Lines(lines, lambda: _vertex_numbers(text)), (0, 1, 2), _A_VERTEX)


def _vertex_numbers(text: bytes) -> list[int]:
    return [
        number
        for number, line in enumerate(text.split(b"\n"), 1)
        for _ in range(line.count(b"vertex"))  # once, except where a facet is written in one line
    ]


def _wrong_line(text: bytes) -> DamagedError | None:
    """Make the error for the first line that cannot stand where it stands; None if there is none."""
    place = 0
    for number, line in enumerate(text.split(b"\n"), 1):
        words = line.split()
        if not words or (place == 0 and words[0] in (b"solid", b"endsolid", b"end")):
            continue
        word, expected = _LINES[place]
        numbers = [] if word != b"vertex" else words[1:4]
        if words[0] != word or (word == b"vertex" and not _are_numbers(numbers)):
            return unexpected(line, number, expected)
        place = (place + 1) % len(_LINES)
    return None


def _are_numbers(words: list[bytes]) -> bool:
    return len(words) == 3 and all(NUMBER.fullmatch(word.replace(b",", b".")) for word in words)


def _triangles(vertices: FloatArray, notes: tuple[str, ...]) -> Polygons:
    corners = np.arange(len(vertices))
    return Polygons(vertices, corners, np.full(len(vertices) // 3, 3), notes)
