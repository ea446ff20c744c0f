# SPDX-License-Identifier: MIT
"""Text files in every common encoding and with every line end."""

from __future__ import annotations

import codecs
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.mesh import read_mesh
from tests.core.mesh.io.mesh_files import POINTS, obj, off, ply, stl_text, write

SCAN = np.random.default_rng(0).random((20, 3))
XYZ = "".join(" ".join(map(repr, point)) + "\n" for point in SCAN.tolist()).encode()
PCD = b"FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 20\nHEIGHT 1\nDATA ascii\n" + XYZ
TEXTS = {
    "a.obj": obj(),
    "a.off": off(),
    "a.ply": ply(kind="ascii"),
    "a.stl": stl_text(),
    "a.xyz": XYZ,
    "a.pcd": PCD,
}
SPELLINGS: dict[str, Callable[[bytes], bytes]] = {
    "UTF-8 mark": lambda text: codecs.BOM_UTF8 + text,
    "UTF-16": lambda text: text.decode().encode("utf-16"),
    "UTF-16 little": lambda text: codecs.BOM_UTF16_LE + text.decode().encode("utf-16-le"),
    "UTF-16 big": lambda text: codecs.BOM_UTF16_BE + text.decode().encode("utf-16-be"),
    "CRLF": lambda text: text.replace(b"\n", b"\r\n"),
    "CR": lambda text: text.replace(b"\n", b"\r"),
    "blank lines": lambda text: text.replace(b"\n", b" \n\n"),
    "no last line end": lambda text: text.rstrip(),
}


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("name", TEXTS)
def test_every_spelling_gives_the_same_mesh(tmp_path: Path, name: str, spelling: str) -> None:
    expected = read_mesh(write(tmp_path, name, TEXTS[name]))
    mesh = read_mesh(write(tmp_path, name, SPELLINGS[spelling](TEXTS[name])))
    assert np.array_equal(mesh.vertices, expected.vertices)
    assert np.array_equal(mesh.faces, expected.faces)


@pytest.mark.parametrize("kind", ["binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("end", [b"\r\n", b"\r"])
def test_line_ends_of_the_header_of_a_binary_ply(tmp_path: Path, kind: str, end: bytes) -> None:
    """The rows may hold the same bytes."""
    data = ply(POINTS + 13.0523, kind=kind)
    start = data.index(b"end_header\n") + 11
    expected = read_mesh(write(tmp_path, "a.ply", data))
    mesh = read_mesh(write(tmp_path, "a.ply", data[:start].replace(b"\n", end) + data[start:]))
    assert np.array_equal(mesh.vertices, expected.vertices)
    assert np.array_equal(mesh.faces, expected.faces)
