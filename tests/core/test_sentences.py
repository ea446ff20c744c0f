# SPDX-License-Identifier: MIT
"""Errors on the ways of users: one plain sentence that names the input and says what to do."""

from __future__ import annotations

import io
import json
import shutil
import sqlite3
from collections.abc import Callable
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

import shapegoogle_core as sg
from shapegoogle_core.cli import main
from tests.core.mesh.io.mesh_files import FILES, POINTS, TRIANGLES, ply
from tests.core.sentences import faults

Action = Callable[[Path], object]

# Name of the input, and what is done with it in an empty folder.
CASES: list[tuple[str, Action]] = []


def case(name: str) -> Callable[[Action], Action]:
    def note(action: Action) -> Action:
        CASES.append((name, action))
        return action

    return note


def written(path: Path, data: bytes | str = b"") -> Path:
    path.write_bytes(data.encode() if isinstance(data, str) else data)
    return path


def shipped() -> bytes:
    return (resources.files("shapegoogle_core") / "model" / "shipped" / "paper.npz").read_bytes()


def packed(**arrays: object) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **{name: np.asarray(array) for name, array in arrays.items()})
    return buffer.getvalue()


def library(folder: Path) -> Path:
    """A library with one box."""
    path = folder / "shapes.sglib"
    with sg.Library.open(path) as opened:
        opened.add(sg.Mesh(POINTS, TRIANGLES, name="box"))
    return path


def changed(folder: Path, *statements: str) -> Path:
    """A library that another program has changed."""
    path = library(folder)
    connection = sqlite3.connect(path)
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()
    return path


MESH_FILES: dict[str, bytes] = {
    "empty.obj": b"",
    "scene.fbx": b"Kaydara FBX Binary",
    "horse": FILES["box.obj"],
    "image.ply": b"\x89PNG\r\n\x1a\n" + bytes(40),
    "packed.stl": b"PK\x03\x04" + bytes(200),
    "points.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\n",
    "triangle.off": b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    "flat.off": b"OFF\n4 2 0\n0 0 0\n1 0 0\n2 0 0\n3 0 0\n3 0 1 2\n3 1 2 3\n",
    "nan.ply": ply(points=POINTS * np.nan),
    "words.xyz": b"one two three\n" * 20,
    "few.xyz": b"0 0 0\n1 1 1\n",
    "half.ply": FILES["box.ply"][:250],
    "half.glb": FILES["box.glb"][:200],
    "half.stl": FILES["box.stl"][:200],
    "list.gltf": b"[]",
    "json.gltf": b"{'a': 1}",
    "old.gltf": b'{"asset": {"version": "1.0"}}',
    "latin.gltf": b'{"asset": {"version": "2.0", "generator": "\xff"}}',
    "header.pcd": b"VERSION 0.7\nFIELDS x y\nDATA ascii\n",
}


@pytest.mark.parametrize("name", MESH_FILES)
def test_mesh_files(name: str, tmp_path: Path) -> None:
    with pytest.raises(sg.MeshError) as caught:
        sg.read_mesh(written(tmp_path / name, MESH_FILES[name]))
    assert not faults(str(caught.value), name)


@case("nowhere.ply")
def missing(folder: Path) -> None:
    sg.read_mesh(folder / "nowhere.ply")


@case("folder.ply")
def a_folder(folder: Path) -> None:
    (folder / "folder.ply").mkdir()
    sg.read_mesh(folder / "folder.ply")


@case("too_many.off")
def too_many_faces(folder: Path) -> None:
    sg.read_mesh(written(folder / "too_many.off", FILES["box.off"]), max_faces=3)


@case("horse")
def vertices_in_the_plane(folder: Path) -> None:
    sg.Mesh([[0, 0], [1, 0], [0, 1]], [[0, 1, 2]], name="horse")


@case("horse")
def words_for_vertices(folder: Path) -> None:
    sg.Mesh([["a", "b", "c"]], [[0, 0, 0]], name="horse")


@case("horse")
def infinite_vertices(folder: Path) -> None:
    sg.Mesh([[0, 0, np.inf]], [[0, 0, 0]], name="horse")


@case("horse")
def faces_beyond_the_vertices(folder: Path) -> None:
    sg.Mesh(POINTS, [[0, 1, 8]], name="horse")


@case("horse")
def faces_of_fractions(folder: Path) -> None:
    sg.Mesh(POINTS, [[0, 1, 2.5]], name="horse")


@case("nowhere.npz")
def a_missing_model(folder: Path) -> None:
    sg.load_model(folder / "nowhere.npz")


@case("model.npz")
def half_a_model(folder: Path) -> None:
    sg.load_model(written(folder / "model.npz", shipped()[:5000]))


@case("model.npz")
def a_flipped_model(folder: Path) -> None:
    data = bytearray(shipped())
    data[len(data) // 2] ^= 0xFF
    sg.load_model(written(folder / "model.npz", bytes(data)))


@case("model.npz")
def other_arrays(folder: Path) -> None:
    sg.load_model(written(folder / "model.npz", packed(a=1)))


@case("model.npz")
def a_newer_model(folder: Path) -> None:
    sg.load_model(written(folder / "model.npz", packed(header=json.dumps({"format": 99}))))


@case("model.npz")
def text_as_a_model(folder: Path) -> None:
    sg.load_model(written(folder / "model.npz", "no model"))


@case("model.npz")
def pickled_objects(folder: Path) -> None:
    buffer = io.BytesIO()
    np.savez(buffer, header=np.array([{}], dtype=object))
    sg.load_model(written(folder / "model.npz", buffer.getvalue()))


@case("nowhere.sglib")
def a_missing_library(folder: Path) -> None:
    sg.Library.open(folder / "nowhere.sglib", read_only=True)


@case("notes.txt")
def text_as_a_library(folder: Path) -> None:
    sg.Library.open(written(folder / "notes.txt", "no library\n" * 100))


@case("shapes.sglib")
def half_a_library(folder: Path) -> None:
    path = library(folder)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with sg.Library.open(path) as opened:
        opened.add(sg.Mesh(POINTS, TRIANGLES, name="box"))
        list(opened.shapes())
        opened.query(sg.Mesh(POINTS, TRIANGLES, name="box"))


@case("shapes.sglib")
def another_database(folder: Path) -> None:
    connection = sqlite3.connect(folder / "shapes.sglib")
    connection.execute("CREATE TABLE birds (name TEXT)")
    connection.commit()
    connection.close()
    sg.Library.open(folder / "shapes.sglib")


@case("shapes.sglib")
def a_newer_library(folder: Path) -> None:
    sg.Library.open(changed(folder, "UPDATE meta SET value = '99' WHERE key = 'schema'"))


@case("shapes.sglib")
def a_library_without_a_table(folder: Path) -> None:
    with sg.Library.open(changed(folder, "DROP TABLE bags")) as opened:
        opened.query(sg.Mesh(POINTS, TRIANGLES, name="box"), explain=1)


@case("shapes.sglib")
def a_closed_library(folder: Path) -> None:
    with sg.Library.open(library(folder)) as opened:
        pass
    opened.info()


@case("shapes.sglib")
def another_model(folder: Path) -> None:
    sg.Library.open(library(folder), model="paper")


@case("shapes.sglib")
def a_change_of_a_read_only_library(folder: Path) -> None:
    with sg.Library.open(library(folder), read_only=True) as opened:
        opened.add(sg.Mesh(POINTS, TRIANGLES, name="box"))


@case("999")
def a_shape_that_is_not_there(folder: Path) -> None:
    with sg.Library.open(library(folder)) as opened:
        opened.signature(999)


@case("file")
def a_library_below_a_file(folder: Path) -> None:
    sg.Library.open(written(folder / "file") / "shapes.sglib")


@case("\\x00")
def a_name_with_a_null_character(folder: Path) -> None:
    sg.Library.open(str(folder / "a\0b.sglib"))


@pytest.mark.parametrize(("name", "action"), CASES, ids=[action.__name__ for _, action in CASES])
def test_what_users_run_into(name: str, action: Action, tmp_path: Path) -> None:
    with pytest.raises(sg.ShapeGoogleError) as caught:
        action(tmp_path)
    said = str(caught.value).replace(str(tmp_path), "…")
    wrong = faults(said, name)
    assert [fault for fault in wrong if name != "\\x00" or "x00" not in fault] == []


COMMANDS = {
    "nowhere": ["index", "{folder}/nowhere", "--library", "{folder}/new.sglib"],
    "notes.txt": ["info", "--library", "{folder}/notes.txt"],
    "half.ply": ["query", "{folder}/half.ply", "--library", "{folder}/shapes.sglib"],
    "missing.ply": ["query", "{folder}/missing.ply", "--library", "{folder}/shapes.sglib"],
    "elsewhere": ["duplicates", "--library", "{folder}/elsewhere/shapes.sglib"],
    "model.npz": ["index", "{folder}", "--library", "{folder}/new.sglib", "--model", "{folder}/model.npz"],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("commands")
    library(folder)
    written(folder / "notes.txt", "no library\n" * 100)
    written(folder / "half.ply", FILES["box.ply"][:250])
    written(folder / "model.npz", shipped()[:5000])
    return folder


@pytest.mark.parametrize("name", COMMANDS)
def test_commands(name: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = main([word.format(folder=folder) for word in COMMANDS[name]])
    said = [line for line in capsys.readouterr().err.splitlines() if name in line]
    assert code in (1, 2)
    assert said
    # A list of what failed may repeat the sentence.
    assert not [fault for line in said for fault in faults(line.replace(str(folder), "…"), name)]


def test_the_disk_is_left_as_it_was(tmp_path: Path) -> None:
    """A library that cannot be used is not changed."""
    path = written(tmp_path / "notes.txt", "no library\n" * 100)
    copy = shutil.copy(path, tmp_path / "copy")
    with pytest.raises(sg.LibraryError):
        sg.Library.open(path)
    assert path.read_bytes() == Path(copy).read_bytes()
