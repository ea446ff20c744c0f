# SPDX-License-Identifier: MIT
"""Reading XYZ: texts of scanners with one point a line."""

from __future__ import annotations

import re

from shapegoogle_core.mesh.io.file import FormatError, MeshFile, check_point_count
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.text import parse_numbers, plain_text

__all__ = ["read_xyz"]


def read_xyz(file: MeshFile) -> Polygons:
    """Read the first three numbers of each line; normals and colours behind them are left out.

    Blanks, tabs, commas or semicolons separate the numbers. Comments begin with # or //; a first line that
    names the columns x, y, z is one.

    Parameters
    ----------
    file : MeshFile

    Returns
    -------
    points : Polygons
        Without faces.

    Raises
    ------
    FormatError
        If a line is not a point, or there are too many.
    """
    text = re.sub(rb"[,;]", b" ", re.sub(rb"(#|//).*", b"", plain_text(file.data)))
    text = re.sub(rb"\A\s*x\s+y\s+z\b.*", b"", text, flags=re.IGNORECASE)
    lines = [line for line in text.split(b"\n") if line.strip()]
    if not lines:
        raise FormatError("has no points: it is empty, or not an XYZ file; export it again")
    check_point_count(len(lines), file.max_faces)
    return Polygons.from_points(parse_numbers(lines, (0, 1, 2), "a point"))
