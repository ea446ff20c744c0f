# SPDX-License-Identifier: MIT
"""Reading: every format gives the same shape, every kind of damage a sentence."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import MESH_SUFFIXES, read_mesh
from shapegoogle_core.mesh.io.file import MeshFile
from shapegoogle_core.mesh.io.polygons import Polygons
from shapegoogle_core.mesh.io.reading import READERS
from shapegoogle_core.preprocessing import repair
from tests.core.mesh.io.mesh_files import (
    AREA,
    FILES,
    MIXED,
    POINTS,
    QUADS,
    TRIANGLES,
    VOLUME,
    Faces,
    Points,
    Writer,
    glb,
    gltf,
    obj,
    off,
    ply,
    refuse,
    stl,
    volume,
    write,
)


@pytest.mark.parametrize("name", FILES)
def test_every_format_gives_the_same_box(tmp_path: Path, name: str) -> None:
    mesh = read_mesh(write(tmp_path, name, FILES[name]))
    assert mesh.name == name
    assert len(mesh.faces) == 12
    assert mesh.area == pytest.approx(AREA)
    assert volume(mesh) == pytest.approx(VOLUME)
    assert len(repair(mesh).vertices) == 8


def test_suffixes(tmp_path: Path) -> None:
    assert sorted(MESH_SUFFIXES) == [".3mf", ".glb", ".gltf", ".obj", ".off", ".pcd", ".ply", ".stl", ".xyz"]
    assert read_mesh(str(write(tmp_path, "BOX.OBJ", obj()))).name == "BOX.OBJ"


@pytest.mark.parametrize(
    "data",
    [
        obj(faces=QUADS),
        obj(faces=MIXED),
        off(faces=QUADS),
        off(faces=MIXED),
        off(faces=[(*face, 255, 0, 0)[:3] for face in TRIANGLES], first="OFF # comment"),
        *(
            ply(faces=f, kind=k)
            for f in (QUADS, MIXED)
            for k in ("ascii", "binary_little_endian", "binary_big_endian")
        ),
        ply(corners="vertex_index"),
    ],
)
def test_polygons_become_triangles(tmp_path: Path, data: bytes) -> None:
    suffix = ".off" if data.startswith(b"OFF") else ".ply" if data.startswith(b"ply") else ".obj"
    mesh = read_mesh(write(tmp_path, "box" + suffix, data))
    assert len(mesh.faces) == 12
    assert volume(mesh) == pytest.approx(VOLUME)


def test_pentagon_is_a_fan(tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [2, 0, 0], [3, 1, 0], [1, 3, 0], [-1, 1, 0]], float)
    for name, data in {"a.obj": obj(points, [range(5)]), "a.off": off(points, [range(5)])}.items():
        mesh = read_mesh(write(tmp_path, name, data))
        assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4]]


def test_cut_short_anywhere(tmp_path: Path) -> None:
    """No beginning of a binary file or of a text with a known end passes for the whole."""
    for name in (
        "box.ply",
        "box_big.ply",
        "box_text.ply",
        "box.stl",
        "box_text.stl",
        "box.glb",
        "box.gltf",
        "box.off",
    ):
        data = FILES[name].rstrip()
        for length in range(0, len(data) - 2, max(len(data) // 40, 1)):
            refuse(write(tmp_path, name, data[:length]))


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.filterwarnings("ignore::shapegoogle_core.MeshWarning")
@pytest.mark.parametrize("name", FILES)
@given(data=st.data())
def test_damage_gives_a_mesh_or_a_mesh_error(tmp_path: Path, name: str, data: st.DataObject) -> None:
    """Flipped bytes, cut ends, doubled and deleted pieces: nothing but MeshError comes out."""
    content = bytearray(FILES[name])
    position = st.integers(0, len(content) - 1)
    for place, value in data.draw(st.lists(st.tuples(position, st.integers(0, 255)), max_size=4)):
        content[place] = value
    if data.draw(st.booleans()):
        begin, end = sorted((data.draw(position), data.draw(position)))
        piece = bytes(content[begin:end])
        content[begin:end] = data.draw(st.sampled_from([b"", piece * 2, b"-" + piece, b"\0\xff", b"9" * 40]))
    path = write(tmp_path, name, bytes(content))
    try:
        mesh = read_mesh(path)
    except MeshError:
        refuse(path)
    else:
        assert np.isfinite(mesh.vertices).all()
        assert mesh.area > 0


@pytest.mark.parametrize("name", FILES)
def test_too_many_faces(tmp_path: Path, name: str) -> None:
    path = write(tmp_path, name, FILES[name])
    refuse(path, "12 faces", "limit of 11", max_faces=11)
    assert len(read_mesh(path, max_faces=12).faces) == 12


def test_file_beyond_any_mesh_of_that_size(tmp_path: Path) -> None:
    path = write(tmp_path, "huge.obj", obj())
    os.truncate(path, 600_000_000)  # a hole, which takes no room
    refuse(path, "600,000,000 bytes", "limit of 12", max_faces=12)


@pytest.mark.parametrize("suffix", sorted(MESH_SUFFIXES))
def test_no_usable_file(tmp_path: Path, suffix: str) -> None:
    refuse(tmp_path / f"missing{suffix}", "does not exist")
    folder = tmp_path / f"folder{suffix}"
    folder.mkdir()
    refuse(folder, "is a folder")
    refuse(write(tmp_path, f"empty{suffix}", b""), "empty")
    refuse(write(tmp_path, f"blank{suffix}", b"\n"))
    refuse(write(tmp_path, f"zeros{suffix}", bytes(3_000_000)))
    refuse(write(tmp_path, f"picture{suffix}", b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 40))
    refuse(write(tmp_path, f"page{suffix}", b"<!DOCTYPE html>\n<html><body>Not found</body></html>\n"))


@pytest.mark.parametrize("name", ["a.txt", "a", ".obj", "a.ply.gz"])
def test_unsupported_suffix(tmp_path: Path, name: str) -> None:
    refuse(write(tmp_path, name, obj()), ".obj", "convert")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("a.STEP", ("is of the format STEP", "export from the CAD program as STL or 3MF")),
        ("a.igs", ("is of the format IGES", "STL or 3MF")),
        ("a.fbx", ("is of the format FBX", "index with Blender")),
        ("a.blend", ("is of the format Blender", "scripts/index_library.py")),
    ],
)
def test_other_formats_are_refused_with_advice(tmp_path: Path, name: str, words: tuple[str, ...]) -> None:
    refuse(write(tmp_path, name, obj()), *words)


def test_content_of_another_format(tmp_path: Path) -> None:
    for name, data in FILES.items():
        for suffix in MESH_SUFFIXES - {Path(name).suffix}:
            refuse(write(tmp_path, "renamed" + suffix, data))
    refuse(write(tmp_path, "renamed.obj", ply()), "begins like a .ply file")
    refuse(write(tmp_path, "renamed.stl", glb()), "begins like a .glb file")


def writers() -> Iterable[tuple[str, Writer]]:
    return {".obj": obj, ".off": off, ".ply": ply, ".stl": stl, ".gltf": gltf, ".glb": glb}.items()


@pytest.mark.parametrize(("suffix", "make"), writers())
def test_no_surface(tmp_path: Path, suffix: str, make: Writer) -> None:
    def refuse_shape(points: Points, faces: Faces, *words: str) -> None:
        refuse(write(tmp_path, "shape" + suffix, make(points, faces)), *words)

    line = np.arange(8)[:, None] * np.array([1.0, 2.0, 3.0])
    refuse_shape(np.ones((8, 3)), TRIANGLES, "coincide")
    refuse_shape(line, TRIANGLES, "no area")
    refuse_shape(POINTS[:3], [(0, 1, 2)], "3 vertices")
    for value in (np.nan, np.inf, -np.inf):
        bad = POINTS.copy()
        bad[2, 1] = value
        refuse_shape(bad, TRIANGLES, "NaN or infinite")
    if suffix not in (".stl",):
        refuse_shape(POINTS, [], "no faces" if suffix in (".obj", ".off", ".ply") else "")
        refuse_shape(POINTS, [*TRIANGLES, (0, 1, 8)], "vert")


@pytest.mark.parametrize(("suffix", "make"), writers())
def test_units_do_not_matter(tmp_path: Path, suffix: str, make: Writer) -> None:
    for unit in (1e-6, 1e6):
        mesh = read_mesh(write(tmp_path, "shape" + suffix, make(POINTS * unit, TRIANGLES)))
        assert mesh.area == pytest.approx(AREA * unit**2)


def test_point_cloud(tmp_path: Path) -> None:
    for name, data in {"a.obj": obj(faces=[]), "a.ply": ply(faces=[]), "a.off": off(faces=[])}.items():
        path = write(tmp_path, name, data)
        refuse(path, "no faces and 8 points")
        cloud = read_mesh(path, point_cloud=True)
        assert cloud.is_point_cloud
        assert np.array_equal(cloud.vertices, POINTS)
    assert read_mesh(write(tmp_path, "b.obj", obj()), point_cloud=True).is_point_cloud
    refuse(write(tmp_path, "c.obj", obj(np.zeros((9, 3)), [])), "coincide", point_cloud=True)
    refuse(write(tmp_path, "d.obj", obj(POINTS[:3], [])), "3 points", point_cloud=True)


def test_memory_running_out_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def exhausted(file: MeshFile) -> Polygons:
        raise MemoryError

    monkeypatch.setitem(READERS.own, ".obj", exhausted)
    refuse(write(tmp_path, "a.obj", obj()), "memory")


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may read everything")
def test_no_permission(tmp_path: Path) -> None:
    path = write(tmp_path, "secret.obj", obj())
    path.chmod(0)
    refuse(path, "permission")


def test_files_of_trimesh(tmp_path: Path) -> None:
    """What another program writes is read: trimesh's exporters, every format."""
    ball = trimesh.creation.icosphere(subdivisions=2)
    for kind, options in [
        ("obj", {}),
        ("ply", {}),
        ("ply", {"encoding": "ascii", "vertex_normal": True}),
        ("stl", {}),
        ("stl_ascii", {}),
        ("off", {}),
        ("glb", {}),
    ]:
        data = ball.export(file_type=kind, **options)
        data = data.encode() if isinstance(data, str) else data
        mesh = read_mesh(write(tmp_path, "ball." + kind.removesuffix("_ascii"), data))
        assert len(mesh.faces) == len(ball.faces)
        assert mesh.area == pytest.approx(ball.area, rel=1e-5)


def test_nothing_is_printed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    for name, data in FILES.items():
        read_mesh(write(tmp_path, name, data))
        if name != "box.obj":
            refuse(write(tmp_path, name, data[: len(data) // 2]))
    assert capfd.readouterr() == ("", "")


def test_arguments_that_are_no_path_or_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, "box.obj", obj())
    with pytest.raises(ValueError, match="max_faces must be a whole number of at least 1, not 'a'"):
        read_mesh(path, max_faces="a")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"a path must be a str or a pathlib\.Path, not None"):
        read_mesh(None)  # type: ignore[arg-type]
    for variable in ("HOME", "USERPROFILE"):
        monkeypatch.setenv(variable, str(tmp_path))
    assert read_mesh("~/box.obj").name == "box.obj"
