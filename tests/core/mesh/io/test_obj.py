# SPDX-License-Identifier: MIT
"""Reading OBJ."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.mesh import read_mesh
from shapegoogle_core.mesh.io.file import MeshFile
from shapegoogle_core.mesh.io.obj import read_obj
from tests.core.mesh.io.mesh_files import POINTS, TRIANGLES, VOLUME, obj, refuse, volume, write


def test_relative_indices_count_back_from_their_line(tmp_path: Path) -> None:
    first, second = obj(faces=[]).decode(), obj(POINTS + 10, faces=[]).decode()
    faces = "".join("f " + " ".join(str(corner - 8) for corner in face) + "\n" for face in TRIANGLES)
    mesh = read_mesh(write(tmp_path, "two.obj", (first + faces + "o second\n" + second + faces).encode()))
    assert volume(mesh) == pytest.approx(2 * VOLUME)
    assert np.ptp(mesh.vertices, axis=0).tolist() == [12, 11, 13]


def test_what_real_files_bring(tmp_path: Path) -> None:
    """Other indices, missing materials, colours, tabs, blanks, continued lines, letters outside UTF-8."""
    text = (
        obj()
        .decode()
        .replace("v ", "v\t")
        .replace("f ", "  f ")
        .replace("# a box", "mtllib no.mtl\no Würfel")
    )
    text = text.replace("f 1 4 3", "vt 0 0\nvn 0 0 1\nusemtl none\nf 1/1/1 \\\n 4//1 3/1\nl 1 2").replace(
        "3.0\n", "3.0 1 0.5 0.5\n"
    )
    mesh = read_mesh(write(tmp_path, "real.obj", text.encode("latin-1")))
    assert len(mesh.vertices) == 8
    assert volume(mesh) == pytest.approx(VOLUME)


def test_texture_does_not_split_vertices(tmp_path: Path) -> None:
    text = obj().decode().replace("f ", "vt 0 0\nvt 1 1\nf ")
    text = "\n".join(
        re.sub(r" (\d+)", rf" \1/{1 + index % 2}", line) if line.startswith("f") else line
        for index, line in enumerate(text.split("\n"))
    )
    mesh = read_mesh(write(tmp_path, "seams.obj", text.encode()))
    assert np.array_equal(mesh.vertices, POINTS)
    assert mesh.faces.tolist() == [list(face) for face in TRIANGLES]


@pytest.mark.parametrize("seed", range(8))
def test_many_lines_at_once_are_read_as_one_by_one(seed: int) -> None:
    """Polygons of all sizes, texture and normals, relative corners, weights and colours, in any mix."""
    rng = np.random.default_rng(seed)
    lines, vertices, faces = [], [], []
    for _ in range(60):
        vertices.append(rng.normal(size=3).tolist())
        lines.append(" ".join(["v", *map(repr, vertices[-1])]) + (" 1 0.5 0" if rng.random() < 0.2 else ""))
        if len(vertices) < 8 or (seed % 2 and rng.random() < 0.5):
            continue
        corners = rng.choice(len(vertices), rng.integers(1, 7) if seed % 4 else 4, replace=False)
        faces.append(corners.tolist())
        relative = rng.random() < 0.3
        spelt = [str(corner - len(vertices) if relative else corner + 1) for corner in corners]
        lines.append("f " + " ".join(one + rng.choice(["", "/7", "//7", "/7/7"]) for one in spelt))
    polygons = read_obj(MeshFile("\n".join(lines).encode(), Path(), 999))
    assert np.array_equal(polygons.vertices, vertices)
    read = np.split(polygons.corners, np.cumsum(polygons.sizes)[:-1])
    assert [face.tolist() for face in read] == faces


@pytest.mark.parametrize("face", ["f", "f ", "f 1 1.5 3", "f 1-2 3", "f 1, 2, 3", "f /1 2 3", "v 1 2 z 4"])
def test_lines_that_numbers_alone_would_not_show(tmp_path: Path, face: str) -> None:
    refuse(
        write(tmp_path, "bad.obj", face.encode() + b"\n" + obj()), f"has {face.strip()!r} in line 1, where a"
    )


@pytest.mark.parametrize("face", ["f 0 1 2", "f 1 2 99", "f 1 2 -9", "f 1 x 3", "v 1 2", "v 1 2 zz"])
def test_damaged_lines(tmp_path: Path, face: str) -> None:
    refuse(write(tmp_path, "bad.obj", obj() + face.encode() + b"\n"))
