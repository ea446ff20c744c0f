# SPDX-License-Identifier: MIT
"""Reading OFF: a text of counts, vertices and polygons, one a line."""

from __future__ import annotations

import re

from shapegoogle_core.mesh.io.file import DamagedError, FormatError, MeshFile, check_face_count
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import filled_lines, parse_numbers, parse_polygons, plain_text

__all__ = ["read_off"]

# Some files of the Princeton and ModelNet collections have "OFF3514 3546 0" in one line.
_HEAD = re.compile(rb"\s*(?:ST)?C?N?OFF\s*(?:(\d+)[ \t]+(\d+)(?!\S))?.*")


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
    head = _HEAD.match(text)
    if head is None:
        raise FormatError(
            "does not begin with the word OFF: it is empty, or not a plain OFF file; export it again"
        )
    if head[1] is None:
        raise FormatError("has no counts of vertices and faces after the word OFF; export it again")
    vertex_count, face_count = int(head[1]), int(head[2])
    if 2 * (vertex_count + face_count) > len(text):
        raise DamagedError(
            f"claims {vertex_count:,} vertices and {face_count:,} faces in {len(file.data):,} bytes"
        )
    check_face_count(face_count, file.max_faces)
    lines = filled_lines(text[head.end() :], vertex_count + face_count)
    vertices = parse_numbers(lines[:vertex_count], (0, 1, 2), "a vertex")
    return Polygons(vertices, *parse_polygons(lines[vertex_count:], 0))
