# SPDX-License-Identifier: MIT
"""OFF, the Object File Format, with or without colours, normals and texture coordinates."""

from __future__ import annotations

import re
from array import array
from pathlib import Path

from shapegoogle_core.mesh.formats.common import (
    FormatError,
    Geometry,
    Polygons,
    check_face_count,
    file_size,
    lines_of,
    points_of,
)

__all__ = ["read_off"]


def read_off(path: Path, max_faces: int) -> Geometry:
    """Read an OFF text file.

    Parameters
    ----------
    path : Path
    max_faces : int

    Returns
    -------
    vertices : (n, 3) array
    faces : (m, 3) array
        Polygons become fans.

    Raises
    ------
    FormatError
    """
    coordinates = array("d")
    polygons = Polygons(max_faces)
    with path.open("rb") as file:
        lines = lines_of(file)
        header = _header_words(next(lines, (0, []))[1])
        number, words = (1, header) if header else next(lines, (1, []))
        try:
            vertex_count, face_count = (int(word) for word in words[:2])
        except ValueError as error:
            raise FormatError(
                "has no counts of vertices and faces after the word OFF; export it again"
            ) from error
        if min(vertex_count, face_count) < 0 or 2 * (vertex_count + face_count) > file_size(path):
            raise FormatError(
                f"claims {vertex_count:,} vertices and {face_count:,} faces, more than a file of "
                f"{file_size(path):,} bytes can hold; it is damaged or was cut short"
            )
        check_face_count(face_count, max_faces)
        try:
            for _ in range(vertex_count):
                number, words = next(lines)
                if len(words) < 3:
                    raise ValueError("a vertex has three coordinates")
                coordinates.extend(map(float, words[:3]))
            for _ in range(face_count):
                number, words = next(lines)
                size = int(words[0])
                if not 0 <= size < len(words):
                    raise ValueError(f"a face of {size} corners has {len(words) - 1} numbers")
                polygons.append(map(int, words[1 : size + 1]))
        except StopIteration:
            raise FormatError(
                f"ends before its {vertex_count:,} vertices and {face_count:,} faces are complete; "
                "it was cut short: copy or export it again"
            ) from None
        except (ValueError, OverflowError) as error:
            raise FormatError(
                f"has a line {number} that cannot be read ({error}); it is damaged or was cut short"
            ) from error
    return points_of(coordinates), polygons.triangles()


def _header_words(words: list[bytes]) -> list[bytes]:
    """Check the first line; return what follows the keyword on it."""
    match = re.fullmatch(rb"((?:ST)?C?N?)(4?)(n?)OFF(.*)", words[0]) if words else None
    if match is None:
        raise FormatError("does not begin with the word OFF: it is empty, or no OFF file; export it again")
    if match[2] or match[3] or b"BINARY" in words:
        raise FormatError(
            "is a binary or four-dimensional OFF file, which cannot be read; export it as plain OFF"
        )
    # Some files of the Princeton and ModelNet collections have "OFF3514 3546 0" in one line.
    return [match[4], *words[1:]] if match[4] else words[1:]
