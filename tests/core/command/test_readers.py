# SPDX-License-Identifier: MIT
"""Another program that reads files: what it answers; what happens when it crashes, hangs or is not there."""

from __future__ import annotations

import json
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core import cli
from shapegoogle_core.errors import MeshError
from shapegoogle_core.indexing import (
    ExternalReader,
    ReaderOption,
    describe_file,
    end_external_readers,
    find_meshes,
    index_files,
    read_shapes,
    readable_suffixes,
)
from shapegoogle_core.library import Library
from shapegoogle_core.model import ShapeModel

# Reads files of numbers: one shape for each, an octahedron as large as the number. What a word stands for
# happens instead.
PROGRAM = """
import json, os, sys, time
from array import array

VERTICES = [1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 2, 0, 0, -1]
FACES = [0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5]
print("a banner")
for line in sys.stdin:
    request = json.loads(line)
    words = open(request["path"]).read().split()
    print("reading", request["path"], "warning: noise on the other stream", file=sys.stderr)
    answer = {"shapes": [], "problems": [], "joined": "joined" in words}
    answer["up_axis"] = 2
    with open(request["output"], "wb") as output:
        for word in words:
            if word == "crash":
                print("something is wrong", flush=True)
                os._exit(3)
            elif word == "hang":
                time.sleep(3600)
            elif word == "error":
                answer = {"error": "the program does not like it"}
            elif word == "problem":
                answer["problems"].append("'Part' is no good")
            elif word != "joined":
                scale = float(word)
                array("f", VERTICES).tofile(output)
                array("i", FACES).tofile(output)
                s = abs(scale)
                matrix = [scale, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 5, 0, 0, 0, 1]
                twin = 0 if answer["shapes"] else None
                record = {"name": request["prefix"] + word, "vertices": 6, "faces": 8, "matrix": matrix}
                answer["shapes"].append({**record, "twin_of": twin})
    print("shapegoogle-answer", json.dumps(answer), flush=True)
"""


@pytest.fixture
def reader(tmp_path: Path):
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    yield ExternalReader(
        suffixes=frozenset({".numbers"}),
        command=(sys.executable, str(program)),
        title="the program",
        offers=(ReaderOption("prefix", ("x", "y"), "what names begin with"),),
        options=(("prefix", "x"),),
        time_limit=5.0,
    )
    end_external_readers()


def write(folder: Path, name: str, text: str) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}.numbers"
    path.write_text(text)
    return path


def test_shapes_of_a_file(reader: ExternalReader, tmp_path: Path) -> None:
    found = read_shapes(write(tmp_path, "two", "1 3 problem"), reader)
    assert [shape.object_name for shape in found.shapes] == ["x1", "x3"]
    assert [shape.twin_of for shape in found.shapes] == [None, 0]
    assert found.problems == ["'Part' is no good"]
    low, high = (shape.mesh.vertices for shape in found.shapes)
    np.testing.assert_allclose(high - [0, 0, 5], 3 * (low - [0, 0, 5]))
    assert found.shapes[0].mesh.faces.tolist()[0] == [0, 2, 4]


def test_a_mirrored_shape_is_not_inside_out(reader: ExternalReader, tmp_path: Path) -> None:
    (shape,) = read_shapes(write(tmp_path, "mirror", "-1"), reader).shapes
    corners = shape.mesh.vertices[shape.mesh.faces]
    volume = np.linalg.det(corners - [0, 0, 5]).sum() / 6
    assert volume > 0


def test_joined_parts(reader: ExternalReader, tmp_path: Path) -> None:
    (shape,) = read_shapes(write(tmp_path, "parts", "1 2 joined"), reader).shapes
    assert (shape.object_name, len(shape.mesh.vertices), len(shape.mesh.faces)) == ("", 12, 16)
    assert shape.mesh.faces.max() == 11


def test_a_program_that_crashes_is_started_again(reader: ExternalReader, tmp_path: Path) -> None:
    message = r"'bad.numbers' crashed the program, which read it \(exit code 3.*something is wrong"
    with pytest.raises(MeshError, match=message):
        read_shapes(write(tmp_path, "bad", "crash"), reader)
    assert len(read_shapes(write(tmp_path, "good", "1"), reader).shapes) == 1
    with pytest.raises(MeshError, match="the program does not like it"):
        read_shapes(write(tmp_path, "refused", "error"), reader)


def test_a_program_that_hangs_is_killed(reader: ExternalReader, tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"'slow\.numbers' was not read by the program after 5 s"):
        read_shapes(write(tmp_path, "slow", "hang"), reader)
    assert len(read_shapes(write(tmp_path, "good", "1"), reader).shapes) == 1


def test_a_program_that_is_not_there(tmp_path: Path) -> None:
    missing = ExternalReader(frozenset({".numbers"}), (str(tmp_path / "none"),), "the program")
    with pytest.raises(MeshError, match="the program cannot be started"):
        read_shapes(write(tmp_path, "good", "1"), missing)
    with pytest.raises(MeshError, match="is not there"):
        read_shapes(tmp_path / "gone.numbers", missing)


def test_without_a_reader(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="convert it first"):
        read_shapes(write(tmp_path, "good", "1"))
    assert ".numbers" not in readable_suffixes(None)


def test_index(reader: ExternalReader, library: Library, tmp_path: Path) -> None:
    folder = tmp_path / "files"
    write(folder, "a", "1 2")
    write(folder, "copy", "1 2")
    write(folder, "crash", "crash")
    write(folder, "empty", "")
    write(folder, "part", "1 problem")

    def index(**options: bool):
        paths = find_meshes([folder], suffixes=readable_suffixes(reader))
        return index_files(library, paths, jobs=1, describe=partial(describe_file, reader=reader), **options)

    report = index()
    assert (report.added, report.shapes) == (3, 5)
    reasons = {path.name: reason for path, reason in report.failed}
    assert set(reasons) == {"crash.numbers", "part.numbers"}
    assert "crashed the program, which read it (exit code 3" in reasons["crash.numbers"]
    assert reasons["part.numbers"] == "'part.numbers': 1 of 2 objects failed: 'Part' is no good"
    shapes = {(Path(shape.source).stem, shape.object_name): shape for shape in library.shapes()}
    assert set(shapes) == {("a", "x1"), ("a", "x2"), ("copy", "x1"), ("copy", "x2"), ("part", "x1")}
    # A twin has the signature of the first, and its own size.
    assert shapes["a", "x2"].area == pytest.approx(4 * shapes["a", "x1"].area)
    assert shapes["copy", "x2"].area == pytest.approx(shapes["a", "x2"].area)
    first, second = (library.signature(shapes["a", name].shape_id) for name in ("x1", "x2"))
    np.testing.assert_array_equal(first.bags, second.bags)

    report = index()
    assert (report.added, report.unchanged, len(report.failed)) == (0, 3, 2)
    assert (index(reread=True).updated, index(retry=True).unchanged) == (2, 3)


def test_command(
    reader: ExternalReader,
    model: ShapeModel,
    library_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture,
) -> None:
    Library.open(library_file, model).close()
    path = write(tmp_path / "files", "two", "1 2")
    arguments = [
        "index",
        str(path.parent),
        "--library",
        str(library_file),
        "--jobs",
        "1",
        "--events",
        "--json",
    ]
    assert cli.main([*arguments, "--prefix", "y"], reader=reader) == 0
    event, summary = map(json.loads, capsys.readouterr().out.splitlines())
    assert event == {"done": 1, "total": 1, "path": str(path), "status": "added", "reason": ""}
    assert (summary["added"], summary["new_shapes"], summary["shapes"]) == (1, 2, 2)

    gone = str(tmp_path / "gone.numbers")
    query = ["query", str(path), gone, "--library", str(library_file), "--json", "--top", "1"]
    assert cli.main(query, reader=reader) == 1
    first, second, third = map(json.loads, capsys.readouterr().out.splitlines())
    assert (first["query"], first["object"], first["matches"][0]["name"]) == (str(path), "x1", "y1")
    assert second["object"] == "x2"
    assert (third["query"], third["matches"]) == (gone, [])
    assert "is not there" in third["error"]
