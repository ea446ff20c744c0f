# SPDX-License-Identifier: MIT
"""A mesh format: the .tri files of brain research, in text.

The number of vertices, a line for each (x y z, perhaps with a normal), the number of triangles, a line for
each with the numbers of its vertices, counted from 1.
"""

import numpy as np

from shapegoogle_core.plugins import FormatError, MeshFile, Polygons


def read_tri(file: MeshFile) -> Polygons:
    """Read a .tri file.

    Parameters
    ----------
    file : MeshFile
        Its content in memory. What a reader raises becomes one sentence that names the file; a `FormatError`
        completes it.

    Returns
    -------
    polygons : Polygons
        Faces that name vertices which are not there are found by the caller.
    """
    lines = [line.split() for line in file.data.decode("ascii", "replace").splitlines() if line.strip()]
    vertex_count = _count(lines, 0, "vertices")
    face_count = _count(lines, 1 + vertex_count, "triangles")
    if face_count > file.max_faces:
        raise FormatError(
            f"has {face_count:,} faces, above the limit of {file.max_faces:,}; simplify it first"
        )
    if len(lines) < 2 + vertex_count + face_count:
        raise FormatError("is cut short; copy or export it again")
    vertices = np.array([line[:3] for line in lines[1 : 1 + vertex_count]], np.float64)
    faces = np.array([line[:3] for line in lines[2 + vertex_count :][:face_count]], np.int64) - 1
    return Polygons.from_triangles(vertices.reshape(-1, 3), faces.reshape(-1, 3))


def _count(lines: list[list[str]], place: int, what: str) -> int:
    if place >= len(lines) or not (len(lines[place]) == 1 and lines[place][0].isdecimal()):
        raise FormatError(f"does not give its number of {what}; export it again")
    return int(lines[place][0])
