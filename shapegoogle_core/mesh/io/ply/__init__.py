# SPDX-License-Identifier: MIT
"""Reading PLY, text and binary: a `header` describes elements, whose `rows` follow.

Not left to trimesh, which in version 5.2 refuses binary polygons of several sizes, as Blender writes them,
splits vertices at texture seams and misreads texts that are cut short.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.io.file import DamagedError, MeshFile, check_face_count
from shapegoogle_core.mesh.io.ply.header import Element, Header, read_header
from shapegoogle_core.mesh.io.ply.rows import Column, Columns, binary_columns, text_columns
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import plain_text, quoted, without_mark

__all__ = ["read_ply"]

# Values of a strip that end it, and let the next one begin: -1, also as an unsigned number.
_SEPARATORS = (-1, 2**32 - 1)


def read_ply(file: MeshFile) -> Polygons:
    """Read the vertices, the faces and the triangle strips of a PLY file.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    polygons : Polygons
        Points alone if there are neither faces nor strips. Notes name the elements that are left out.

    Raises
    ------
    FormatError
        If the header is damaged or does not fit the rows, or there are too many faces.
    """
    data = without_mark(file.data)
    header = read_header(data)
    _check_lengths(header, len(data), file.max_faces)
    elements = [element for element in header.elements if element.length]
    if header.is_text:
        columns, rest = text_columns(plain_text(data[header.start :]), header.line_count + 1, elements)
    else:
        columns, rest = binary_columns(data, header.start, elements)
    vertices = np.empty((0, 3))
    if "vertex" in columns:
        with np.errstate(invalid="ignore"):  # some kinds of NaN
            vertices = np.stack([values for values, _ in columns["vertex"]], axis=1).astype(np.float64)
    corners, sizes = _faces(columns, file.max_faces)
    return Polygons(vertices, corners, sizes, _notes(elements, rest))


def _check_lengths(header: Header, byte_count: int, max_faces: int) -> None:
    names = [element.name for element in header.elements]
    for element in header.elements:
        if names.count(element.name) > 1:
            raise DamagedError(f"has the element {quoted(element.name)} several times in its PLY header")
        if element.name == "face":
            check_face_count(element.length, max_faces)
        # A row has at least one byte.
        if element.properties and element.length > byte_count - header.start:
            raise DamagedError(
                f"claims {element.length:,} times the element {quoted(element.name)} in "
                f"{byte_count - header.start:,} bytes"
            )


def _faces(columns: Columns, max_faces: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return corners and sizes of the faces, then of the triangles of the strips."""
    corners, sizes = np.empty(0, np.int64), np.empty(0, np.int64)
    if "face" in columns:
        corners, sizes = _indices("face", columns["face"][0]), columns["face"][0][1]
    if "tristrips" in columns:
        strips = columns["tristrips"][0]
        triangles = _strip_triangles(_indices("tristrips", strips), strips[1])
        check_face_count(len(triangles), max_faces)
        corners = np.concatenate([corners, triangles.ravel()])
        sizes = np.concatenate([sizes, np.full(len(triangles), 3)])
    return corners, sizes


def _indices(name: str, column: Column) -> NDArray[np.int64]:
    values: NDArray[np.int64]
    with np.errstate(invalid="ignore"):
        values = column[0].astype(np.int64)
    wrong = np.flatnonzero(values != column[0])
    if len(wrong):
        row = int(np.searchsorted(np.cumsum(column[1]), wrong[0], "right"))
        raise DamagedError(
            f"has {column[0][wrong[0]]:g} in row {row:,} of the element {name!r}, "
            "where a whole number is expected"
        )
    return values


def _strip_triangles(values: NDArray[np.int64], sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the triangles of strips: each value and the two before it, every second one turned round."""
    ended = np.insert(values, np.cumsum(sizes), -1)
    is_end = np.isin(ended, _SEPARATORS)
    places = np.arange(len(ended))
    starts = np.maximum.accumulate(np.where(is_end, places + 1, 0))
    last = np.flatnonzero(~is_end & (places - starts >= 2))
    triangles = ended[last[:, None] + np.array([-2, -1, 0])]
    turned = (last - starts[last]) % 2 == 1
    triangles[turned] = triangles[turned][:, [1, 0, 2]]
    a, b, c = triangles.T
    # Strips are joined by triangles that use a vertex twice.
    found: NDArray[np.int64] = triangles[(a != b) & (b != c) & (c != a)]
    return found


def _notes(elements: Sequence[Element], rest: str) -> tuple[str, ...]:
    notes = []
    unread = [f"{quoted(element.name)} ({element.length:,})" for element in elements if not element.wanted()]
    if unread:
        notes.append(f"has elements that were not read: {', '.join(unread)}")
    if rest:
        notes.append(f"has {rest} behind the rows that its header announces; they were not read")
    return tuple(notes)
