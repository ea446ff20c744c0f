# SPDX-License-Identifier: MIT
"""Files of points alone: XYZ, PCD, and PLY without faces."""

from __future__ import annotations

import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from shapegoogle_core.errors import MeshError, MeshWarning
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.mesh.mesh import FloatArray
from tests.core.mesh.io.mesh_files import write

KINDS_OF_PCD = ("ascii", "binary", "binary_compressed")
POINTS = np.random.default_rng(0).standard_normal((50, 3)).round(3)


def exported(**options: str) -> bytes | str:
    cloud: Any = trimesh.PointCloud
    data: bytes | str = cloud(POINTS).export(**options)
    return data


def xyz(points: FloatArray = POINTS, separator: str = " ", more: str = "") -> str:
    return "".join(separator.join(map(str, point)) + more + "\n" for point in points)


def pcd(encoding: str = "ascii", points: FloatArray = POINTS, kind: str = "f4", **changes: str) -> bytes:
    """With a filler before, and a colour and three normals after the position."""
    record = np.dtype(
        [("_", "u1", 2), *((axis, "<" + kind) for axis in "xyz"), ("rgb", "<u4"), ("n", "<f4", 3)]
    )
    records = np.zeros(len(points), record)
    for axis, values in zip("xyz", points.T, strict=True):
        records[axis] = values
    records["rgb"] = 7
    lines = {
        "VERSION": "0.7",
        "FIELDS": "_ x y z rgb n",
        "SIZE": f"1 {kind[1]} {kind[1]} {kind[1]} 4 4",
        "TYPE": "U F F F U F",
        "COUNT": "2 1 1 1 1 3",
        "WIDTH": str(len(points)),
        "HEIGHT": "1",
        "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": str(len(points)),
        **changes,
        "DATA": encoding,
    }
    head = "# .PCD v0.7\n" + "".join(f"{name} {value}\n" for name, value in lines.items() if value)
    if encoding == "ascii":
        rows = ["0 0 " + " ".join(map(str, point)) + " 7 0 0 0" for point in points.tolist()]
        return (head + "\n".join(rows) + "\n").encode()
    if encoding == "binary":
        return head.encode() + records.tobytes()
    fields = b"".join(np.ascontiguousarray(records[name]).tobytes() for name in records.dtype.names or ())
    packed = lzf(fields)
    return head.encode() + struct.pack("<2I", len(packed), len(fields)) + packed


def lzf(data: bytes) -> bytes:
    """A packer that writes references, also long ones and into themselves, where bytes repeat."""
    packed, at = bytearray(), 0
    while at < len(data):
        run = 1
        while (
            at > 0 and run < 264 and at + run <= len(data) and data[at : at + run] == data[at - 1 : at] * run
        ):
            run += 1
        run -= 1
        if run >= 9:
            packed += bytes([7 << 5, run - 9, 0])
            at += run
        elif run >= 3:
            packed += bytes([(run - 2) << 5, 0])
            at += run
        else:
            packed += bytes([0, data[at]])
            at += 1
    return bytes(packed)


@pytest.mark.parametrize(
    "text",
    [
        xyz(),
        xyz(separator="\t", more=" 255 0 0"),
        xyz(separator=","),
        xyz(separator=" ; "),
        "# scanned\n\n" + xyz(more="  # good"),
        "//X,Y,Z\n" + xyz(separator=","),
        "x y z\n" + xyz(),
        xyz().replace("\n", "\r\n"),
    ],
)
def test_xyz(tmp_path: Path, text: str) -> None:
    cloud = read_mesh(write(tmp_path, "scan.xyz", text))
    assert cloud.is_point_cloud
    assert cloud.name == "scan.xyz"
    np.testing.assert_array_equal(cloud.vertices, POINTS)


@pytest.mark.parametrize("kind", ["f4", "f8"])
@pytest.mark.parametrize("encoding", KINDS_OF_PCD)
def test_pcd(tmp_path: Path, encoding: str, kind: str) -> None:
    cloud = read_mesh(write(tmp_path, "scan.PCD", pcd(encoding, kind=kind)))
    assert cloud.is_point_cloud
    np.testing.assert_allclose(cloud.vertices, POINTS, rtol=1e-6)


def test_pcd_without_optional_lines(tmp_path: Path) -> None:
    text = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 25\nHEIGHT 2\nDATA ascii\n" + xyz()
    np.testing.assert_array_equal(read_mesh(write(tmp_path, "a.pcd", text)).vertices, POINTS)


def test_points_without_position_are_counted_and_left_out(tmp_path: Path) -> None:
    points = np.vstack([POINTS, np.full((9, 3), np.nan)])
    points[50, 2], points[51, 0], points[52, 1] = 1, np.inf, -np.inf
    files: dict[str, bytes | str] = {f"{kind}.pcd": pcd(kind, points) for kind in KINDS_OF_PCD}
    files |= {"a.xyz": xyz(points), "b.xyz": xyz(points, separator=";").replace("nan", "-1.#IND")}
    header = "".join(f"property double {axis}\n" for axis in "xyz")
    ply = f"ply\nformat ascii 1.0\nelement vertex 59\n{header}end_header\n"
    files |= {"a.ply": ply + xyz(points).replace("nan", "nan(ind)")}
    files |= {"b.ply": ply.replace("ascii", "binary_big_endian").encode() + points.astype(">f8").tobytes()}
    for name, data in files.items():
        with pytest.warns(MeshWarning, match=f"'{name}' has 9 of 59 points without finite coordinates"):
            cloud = read_mesh(write(tmp_path, name, data))
        np.testing.assert_allclose(cloud.vertices, POINTS, rtol=1e-6)


def test_ply_without_faces(tmp_path: Path) -> None:
    for encoding in ("ascii", "binary"):
        data = exported(file_type="ply", encoding=encoding)
        cloud = read_mesh(write(tmp_path, "scan.ply", data))
        assert cloud.is_point_cloud
        np.testing.assert_allclose(cloud.vertices, POINTS, rtol=1e-6)


def test_what_trimesh_writes(tmp_path: Path) -> None:
    data = exported(file_type="xyz")
    np.testing.assert_allclose(read_mesh(write(tmp_path, "scan.xyz", data)).vertices, POINTS)


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.xyz", "", "empty"),
        ("a.xyz", "# nothing\n", "no points"),
        ("a.xyz", xyz()[:-8], "where a point"),
        ("a.xyz", xyz() + "1 2\n", "where a point"),
        ("a.xyz", xyz() + "1 2 x\n", "where a point"),
        ("a.xyz", "3\nwater\nO 0 0 0\nH 0 0 1\nH 0 1 0\n", "where a point"),
        ("a.xyz", xyz(POINTS[:9]), "no faces and 9 points"),
        ("a.xyz", xyz(np.repeat(POINTS[:3], 10, axis=0)), "only 3 distinct"),
        ("a.xyz", xyz(np.outer(np.arange(30.0), [1, 2, 3])), "on a line"),
        ("a.xyz", xyz(POINTS * 1e200), "scale the points"),
        ("a.pcd", pcd("binary")[:-1], "1,500 bytes from byte 161 on, but has 1,499"),
        ("a.pcd", pcd("binary_compressed")[:-1], "cut short"),
        ("a.pcd", pcd("ascii")[:-200], "ends after 4. of the 50 lines"),
        ("a.pcd", pcd("ascii").split(b"DATA")[0], "DATA"),
        ("a.pcd", pcd(FIELDS="_ x y w rgb n"), "in line 3, where a list of fields"),
        ("a.pcd", pcd(SIZE="1 3 4 4 4 4"), "in line 4, where SIZE and 6 times"),
        ("a.pcd", pcd(TYPE="U F F Q U F"), "in line 5, where TYPE and 6 times"),
        ("a.pcd", pcd(COUNT="2 2 1 1 1 3"), "in line 3, where a list of fields"),
        ("a.pcd", pcd(SIZE=""), "has no line SIZE"),
        ("a.pcd", pcd(POINTS="-3"), "in line 10, where a number of points"),
        ("a.pcd", pcd(POINTS="99999999"), "limit"),
        ("a.pcd", pcd().replace(b"DATA ascii", b"DATA zipped"), "unknown kind of data 'zipped' in line 11"),
    ],
)
def test_what_is_refused(tmp_path: Path, name: str, data: str | bytes, words: str) -> None:
    with pytest.raises(MeshError, match="'a\\.") as caught:
        read_mesh(write(tmp_path, name, data))
    assert re.search(words, str(caught.value)), caught.value


def test_damaged_compression(tmp_path: Path) -> None:
    """No damage crashes the reader, or gives more points."""
    whole = bytearray(pcd("binary_compressed"))
    start = whole.index(b"binary_compressed\n") + len(b"binary_compressed\n") + 8
    random = np.random.default_rng(0)
    for _ in range(200):
        data = bytearray(whole)
        data[random.integers(start, len(data))] = random.integers(256)
        try:
            cloud = read_mesh(write(tmp_path, "a.pcd", bytes(data)))
        except MeshError:
            continue
        assert len(cloud.vertices) <= 50


def test_too_many_points(tmp_path: Path) -> None:
    files: dict[str, bytes | str] = {
        "a.xyz": xyz(np.random.default_rng(0).random((2000, 3))),
        "a.pcd": pcd(),
        "a.ply": exported(file_type="ply"),
    }
    for name, data in files.items():
        with pytest.raises(MeshError, match="points, above the limit of 12; thin it"):
            read_mesh(write(tmp_path, name, data), max_faces=12)


def test_curves_are_no_scans(tmp_path: Path) -> None:
    text = "".join("v " + " ".join(map(str, point)) + "\n" for point in POINTS)
    path = write(tmp_path, "curve.obj", text)
    with pytest.raises(MeshError, match="no faces and 50 points"):
        read_mesh(path)
    assert read_mesh(path, point_cloud=True).is_point_cloud
    assert isinstance(read_mesh(path, point_cloud=True), Mesh)
