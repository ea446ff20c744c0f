# SPDX-License-Identifier: MIT
"""Reading PLY."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.errors import MeshWarning
from shapegoogle_core.mesh import read_mesh
from tests.core.mesh.io.mesh_files import MIXED, POINTS, TRIANGLES, VOLUME, ply, refuse, volume, write


def test_more_properties_and_elements(tmp_path: Path) -> None:
    data = ply(faces=MIXED).replace(
        b"property list uchar int vertex_indices",
        b"property list uchar int vertex_indices\nproperty float quality\n"
        b"element extra 1\nproperty list int short values",
    )
    head, body = data[: data.index(b"end_header\n") + 11], data[data.index(b"end_header\n") + 11 :]
    vertices, faces = body[: 13 * 8], body[13 * 8 :]
    rows, position = b"", 0
    while position < len(faces):
        end = position + 2 + 4 * faces[position + 1]
        rows += faces[position:end] + struct.pack("<f", 0.5)
        position = end
    path = write(tmp_path, "more.ply", head + vertices + rows + struct.pack("<i2h", 2, 1, 2))
    with pytest.warns(MeshWarning, match=r"elements that were not read: 'extra' \(1\)"):
        mesh = read_mesh(path)
    assert volume(mesh) == pytest.approx(VOLUME)


def test_element_before_the_vertices(tmp_path: Path) -> None:
    data = ply(kind="ascii").replace(b"element vertex", b"element camera 1\nproperty float f\nelement vertex")
    data = data.replace(b"end_header\n", b"end_header\n35.0\n")
    with pytest.warns(MeshWarning, match="'camera'"):
        mesh = read_mesh(write(tmp_path, "camera.ply", data))
    assert volume(mesh) == pytest.approx(VOLUME)


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_polygons_of_many_sizes(tmp_path: Path, kind: str) -> None:
    """Faces of 1 to 6 corners; those of one or two are no surface."""
    points = np.array([[2, 0, 0], [1, 2, 0], [-1, 2, 0], [-2, 0, 0], [-1, -2, 0], [1, -2, 0]], float)
    faces = [range(size) for size in (5, 3, 6, 1, 4, 2, 6)]
    mesh = read_mesh(write(tmp_path, "sizes.ply", ply(points, faces, kind)))
    assert len(mesh.faces) == 3 + 1 + 4 + 2 + 4
    assert mesh.area == pytest.approx(10 + 2 + 12 + 6 + 12)


def test_sizes_that_add_up_to_as_many_bytes(tmp_path: Path) -> None:
    """A triangle, a quad and a pentagon take as much room as three quads."""
    points = np.array([[2, 0, 0], [1, 2, 0], [-1, 2, 0], [-2, 0, 0], [0, -3, 0]], float)
    mesh = read_mesh(write(tmp_path, "sum.ply", ply(points, [range(4), range(3), range(5)])))
    assert mesh.faces.tolist() == [[0, 1, 2], [2, 3, 0], [0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 3, 4]]


def test_texture_does_not_split_vertices(tmp_path: Path) -> None:
    """Texture coordinates at every corner, of one length or not, as scanners and MeshLab write them."""
    head = ply(faces=TRIANGLES).replace(
        b"property list uchar int vertex_indices",
        b"property list uchar int vertex_indices\nproperty list uchar float texcoord",
    )
    head = head[: head.index(b"end_header\n") + 11 + 13 * 8]
    for sizes in ([6] * 12, [6, 0] * 6):
        rows = b"".join(
            struct.pack(f"<BB3iB{size}f", 1, 3, *face, size, *np.arange(index, index + size))
            for index, (face, size) in enumerate(zip(TRIANGLES, sizes, strict=True))
        )
        mesh = read_mesh(write(tmp_path, "texture.ply", head + rows + b"and more"))
        assert np.array_equal(mesh.vertices, POINTS)
        assert mesh.faces.tolist() == [list(face) for face in TRIANGLES]
    data = ply(kind="ascii").replace(b"property uchar red", b"property float s\nproperty float t")
    data = data.replace(b" 7\n", b" 0.5 0.25\n\n", len(POINTS))
    mesh = read_mesh(write(tmp_path, "seam.ply", data))
    assert np.array_equal(mesh.vertices, POINTS)
    assert mesh.faces.tolist() == [list(face) for face in TRIANGLES]


def test_cut_short(tmp_path: Path) -> None:
    for cut in (1, 30, 150, 230):
        refuse(write(tmp_path, "cut.ply", ply()[:-cut]), "cut short")
    lines = ply(kind="ascii").splitlines(keepends=True)
    for count in range(9, len(lines)):
        refuse(write(tmp_path, "cut.ply", b"".join(lines[:count])), "cut short")


@pytest.mark.parametrize("element", ["vertex 8", "face 12"])
@pytest.mark.parametrize("count", [10**6, 10**9, 10**15, -1])
def test_header_claims_more_than_the_file_holds(tmp_path: Path, element: str, count: int) -> None:
    data = ply().replace(f"element {element}".encode(), f"element {element.split()[0]} {count}".encode())
    refuse(write(tmp_path, "huge.ply", data))


@pytest.mark.parametrize("index", [8, -1, 2**31 - 1])
def test_face_index_out_of_range(tmp_path: Path, index: int) -> None:
    for kind in ("ascii", "binary_little_endian"):
        refuse(write(tmp_path, "range.ply", ply(faces=[*TRIANGLES, (0, 1, index)], kind=kind)), "vert")


def test_header_with_lines_of_other_programs(tmp_path: Path) -> None:
    data = ply().replace(b"comment made by a test", b"obj_info scanned\ncamera 1 2 3\n\nVERSION 7")
    assert volume(read_mesh(write(tmp_path, "more.ply", data))) == pytest.approx(VOLUME)


@pytest.mark.parametrize(
    "line",
    [b"element face", b"property float", b"property list uchar int", b"format ascii7 1.0", b"property x y"],
)
def test_damaged_header(tmp_path: Path, line: bytes) -> None:
    data = ply().replace(b"comment made by a test", line)
    refuse(write(tmp_path, "header.ply", data), f"has {line.decode()!r} in line 3, where")


def test_header_without_what_is_needed(tmp_path: Path) -> None:
    refuse(write(tmp_path, "axis.ply", ply().replace(b"property float y", b"property float v")), "'y'")
    data = ply(corners="corners").replace(b"list uchar int", b"list uchar float")
    refuse(write(tmp_path, "corner.ply", data), "'vertex_indices'")
    data = ply().replace(b"list uchar int", b"list float int")
    refuse(
        write(tmp_path, "count.ply", data),
        "has 'property list float int vertex_indices' in line 11, where a list",
    )


def test_lists_before_the_corners(tmp_path: Path) -> None:
    """In a text the column of the corners then differs from row to row."""
    data = ply(kind="ascii").replace(b"property uchar flags", b"property list uchar float weights")
    head, body = data[: data.index(b"end_header\n") + 11], data[data.index(b"end_header\n") + 11 :]
    rows = body.split(b"\n")
    faces = [
        b"2 0.5 0.25 " + row[2:] if index % 2 else b"0 " + row[2:] for index, row in enumerate(rows[8:20])
    ]
    mesh = read_mesh(write(tmp_path, "lists.ply", head + b"\n".join(rows[:8] + faces)))
    assert mesh.faces.tolist() == [list(face) for face in TRIANGLES]
    faces[3] = b"two 0.5 0.25 3 0 1 2"
    refuse(write(tmp_path, "lists.ply", head + b"\n".join(rows[:8] + faces)), "'two 0.5 0.25 3 0 1 2'")


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian"])
def test_decimals_are_rounded_to_the_declared_type(tmp_path: Path, kind: str) -> None:
    """0.1 as a float of four bytes is the same number in a text as in a binary file."""
    points = POINTS + 0.1
    mesh = read_mesh(write(tmp_path, "tenth.ply", ply(points, kind=kind)))
    assert np.array_equal(mesh.vertices, points.astype(np.float32))


def test_vertices_with_lists_of_different_lengths(tmp_path: Path) -> None:
    """Such as the faces around each vertex."""
    data = ply().replace(b"property uchar red", b"property list uchar int around\nproperty uchar red")
    start = data.index(b"end_header\n") + 11
    rows = [data[start + 13 * row : start + 13 * row + 13] for row in range(8)]
    lists = [struct.pack(f"<B{row}i", row, *range(row)) for row in range(8)]
    vertices = b"".join(row[:12] + own + row[12:] for row, own in zip(rows, lists, strict=True))
    mesh = read_mesh(write(tmp_path, "around.ply", data[:start] + vertices + data[start + 13 * 8 :]))
    assert np.array_equal(mesh.vertices, POINTS)
    assert volume(mesh) == pytest.approx(VOLUME)


def test_lists_that_are_not_in_the_rows(tmp_path: Path) -> None:
    """The header announces a list before the corners of a face, the rows have the corners alone."""
    data = ply(kind="ascii").replace(b"property uchar flags", b"property list uchar int flags")
    path = write(tmp_path, "lists.ply", data.replace(b"\n1 3 ", b"\n3 "))
    refuse(path, "line", "where a polygon")
