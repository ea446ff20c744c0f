# SPDX-License-Identifier: MIT
"""Reading STL."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from shapegoogle_core.mesh import read_mesh
from tests.core.mesh.io.mesh_files import POINTS, VOLUME, refuse, stl, stl_text, volume, write


def test_cut_short(tmp_path: Path) -> None:
    refuse(write(tmp_path, "cut.stl", stl()[:-1]), "cut short")
    refuse(write(tmp_path, "cut.stl", stl()[:60]), "60 bytes")
    refuse(write(tmp_path, "cut.stl", stl_text()[:-20]), "cut short")
    refuse(write(tmp_path, "cut.stl", stl_text()[:500]), "cut short")


def test_facets_that_are_no_triangles(tmp_path: Path) -> None:
    second = b"endfacet\nfacet normal 0 0 0\n outer loop\n"
    first, rest = stl_text().split(b" endloop\n" + second, 1)
    *lines, last = first.splitlines(keepends=True)
    data = b"".join(lines) + b" endloop\n" + second + last + rest  # two vertices, then four
    refuse(write(tmp_path, "moved.stl", data), "has 'endloop' in line 6, where a vertex")
    refuse(
        write(tmp_path, "two.stl", stl_text().replace(b"0.0 0.0 0.0", b"0.0 0.0", 1)),
        "'vertex 0.0 0.0' in line 4",
    )


def test_count_beyond_the_file(tmp_path: Path) -> None:
    data = stl()[:80] + struct.pack("<I", 2**32 - 1) + stl()[84:]
    refuse(write(tmp_path, "huge.stl", data), "4,294,967,295 triangles")


def test_several_solids(tmp_path: Path) -> None:
    data = stl_text() + stl_text(POINTS + 10)
    assert volume(read_mesh(write(tmp_path, "two.stl", data))) == pytest.approx(2 * VOLUME)


def test_any_name(tmp_path: Path) -> None:
    for name in ("vertex 1 2", "a solid of facets", "Würfel"):
        data = stl_text().replace(b"solid box", f"SOLID {name}".encode("latin-1"))
        assert volume(read_mesh(write(tmp_path, "name.stl", data))) == pytest.approx(VOLUME)


def test_binary_that_begins_with_solid(tmp_path: Path) -> None:
    assert len(read_mesh(write(tmp_path, "solid.stl", b"solid" + stl()[5:])).faces) == 12
