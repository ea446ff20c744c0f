# SPDX-License-Identifier: MIT
"""Wavefront OBJ: `v` and `f` lines; materials, textures, normals and free-form surfaces are skipped."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from pathlib import Path

from shapegoogle_core.mesh.formats.common import FormatError, Geometry, Polygons, lines_of, points_of

__all__ = ["read_obj"]


def read_obj(path: Path, max_faces: int) -> Geometry:
    """Read all objects and groups of an OBJ file as one mesh.

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
        for number, words in _continued(lines_of(file)):
            try:
                if words[0] == b"v":
                    if len(words) < 4:
                        raise ValueError("a vertex has three coordinates")
                    coordinates.extend(map(float, words[1:4]))
                elif words[0] == b"f":
                    vertex_count = len(coordinates) // 3
                    polygons.append([_corner(word, vertex_count) for word in words[1:]])
            except (ValueError, OverflowError) as error:
                raise FormatError(
                    f"has a line {number} that cannot be read ({error}); it is damaged or was cut short"
                ) from error
    if not coordinates:
        raise FormatError("has no vertex lines: it is empty, or no OBJ file; export it again")
    return points_of(coordinates), polygons.triangles()


def _corner(word: bytes, vertex_count: int) -> int:
    """Turn `7`, `7/1/3` or `-2` (the last vertex but one so far) into an index from 0."""
    index = int(word.partition(b"/")[0])
    if index > 0:
        return index - 1
    if index == 0:
        raise ValueError("vertices are counted from 1, not 0")
    if index + vertex_count < 0:
        raise ValueError(f"vertex {index} of {vertex_count} vertices so far")
    return index + vertex_count


def _continued(lines: Iterator[tuple[int, list[bytes]]]) -> Iterator[tuple[int, list[bytes]]]:
    """Join lines that end in a backslash with the next."""
    begun: list[bytes] = []
    for number, words in lines:
        if words[-1].endswith(b"\\"):
            begun += [*words[:-1], words[-1][:-1]] if len(words[-1]) > 1 else words[:-1]
            continue
        yield number, begun + words if begun else words
        begun = []
    if begun:
        raise FormatError("ends in the middle of a line: it was cut short; copy or export it again")
