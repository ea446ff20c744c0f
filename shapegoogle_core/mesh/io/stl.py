# SPDX-License-Identifier: MIT
"""Reading STL, binary and text: triangles with three vertices of their own each."""

from __future__ import annotations

import re

import numpy as np

from shapegoogle_core.mesh.io.file import DamagedError, MeshFile, check_face_count
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import parse_numbers, plain_text
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["read_stl"]

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_FACET = re.compile(rb"\bvertex((?:[ \t]+[-+.\w]+){3})[ \t]*\n\s*" * 3 + rb"end")


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
        If the length is not the one that the file announces, a facet of a text is not a triangle, or there
        are too many faces.
    """
    data = file.data
    count = int.from_bytes(data[80:84], "little")
    # Binary files may begin with the word solid too, so their length decides.
    if len(data) == 84 + _RECORD.itemsize * count:
        check_face_count(count, file.max_faces)
        vertices = np.frombuffer(data, _RECORD, count, 84)["corners"].reshape(-1, 3).astype(np.float64)
    else:
        text = plain_text(data).lower()
        if text.lstrip()[:5] != b"solid":
            raise DamagedError(
                f"claims {count:,} triangles, which take {84 + _RECORD.itemsize * count:,} bytes, but has "
                f"{len(data):,} bytes, or is not an STL file"
            )
        vertices = _text_vertices(text, file.max_faces)
    return Polygons.from_triangles(vertices, np.arange(len(vertices)).reshape(-1, 3))


def _text_vertices(text: bytes, max_faces: int) -> FloatArray:
    text = re.sub(rb"^\s*(end ?)?solid\b.*", rb"\1solid", text, flags=re.MULTILINE)  # names say anything
    if not re.search(rb"\bend ?solid\s*\Z", text):
        raise DamagedError("ends before the word endsolid")
    facet_count = text.count(b"endfacet")
    check_face_count(facet_count, max_faces)
    triangles = _FACET.findall(text)
    if not 3 * len(triangles) == 3 * facet_count == text.count(b"vertex"):
        raise DamagedError(f"has {facet_count:,} facets, of which {len(triangles):,} are triangles")
    lines = [vertex for triangle in triangles for vertex in triangle]
    return parse_numbers(lines, (0, 1, 2), "a vertex")
