# SPDX-License-Identifier: MIT
"""Reading OFF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.mesh import read_mesh
from tests.core.mesh.io.mesh_files import POINTS, TRIANGLES, VOLUME, off, refuse, volume, write


@pytest.mark.parametrize("first", ["COFF", "NOFF", "STCNOFF"])
def test_vertices_with_colours_and_normals(tmp_path: Path, first: str) -> None:
    points = np.column_stack([POINTS, np.full((8, 4), 0.5)])
    data = off(faces=TRIANGLES, first=first).decode().split("\n")
    data[2:10] = [" ".join(map(str, row)) for row in points]
    assert volume(read_mesh(write(tmp_path, "colour.off", "\n".join(data).encode()))) == pytest.approx(VOLUME)


def test_counts_behind_the_word(tmp_path: Path) -> None:
    data = off().replace(b"OFF\n", b"OFF")
    assert len(read_mesh(write(tmp_path, "joined.off", data)).faces) == 12


def test_damage(tmp_path: Path) -> None:
    refuse(write(tmp_path, "cut.off", off()[:-10]), "cut short")
    refuse(write(tmp_path, "word.off", b"hello" + off()), "OFF")
    refuse(write(tmp_path, "huge.off", off().replace(b"8 12 0", b"8 1200000 0")), "1,200,000 faces")
    refuse(
        write(tmp_path, "huge.off", off().replace(b"8 12 0", b"8000000000 12 0")),
        "8,000,000,000 vertices",
    )
    refuse(write(tmp_path, "range.off", off(faces=[*TRIANGLES, (0, 1, -2)])), "vert")
    refuse(write(tmp_path, "letter.off", off().replace(b"3.0", b"3\xff0", 1)))
    remark = off().replace(b"OFF", "OFF # Würfel".encode("latin-1"))
    assert len(read_mesh(write(tmp_path, "remark.off", remark)).faces) == 12
    refuse(write(tmp_path, "counts.off", off().replace(b"8 12 0", b"many")), "counts")


def test_polygons_of_many_sizes(tmp_path: Path) -> None:
    """Faces of 1 to 6 corners, some with colours; those of one or two are not part of the surface."""
    points = np.array([[2, 0, 0], [1, 2, 0], [-1, 2, 0], [-2, 0, 0], [-1, -2, 0], [1, -2, 0]], float)
    data = off(points, [range(size) for size in (5, 3, 6, 1, 4, 2, 6)]).replace(
        b"3 0 1 2", b"3 0 1 2 0.5 0 0"
    )
    mesh = read_mesh(write(tmp_path, "sizes.off", data))
    assert len(mesh.faces) == 3 + 1 + 4 + 2 + 4
    assert mesh.area == pytest.approx(10 + 2 + 12 + 6 + 12)


@pytest.mark.parametrize(
    "face", ["3 0 1", "3 0 1 1.5", "3 0 1 x", "-3 0 1 2", "99999999999 0 1 2", "nan 0 1 2"]
)
def test_damaged_faces(tmp_path: Path, face: str) -> None:
    data = off(faces=[*TRIANGLES, (7, 7, 7)]).replace(b"3 7 7 7", face.encode())
    refuse(write(tmp_path, "face.off", data), f"has {face!r} in line 23, where a polygon")
