# SPDX-License-Identifier: MIT
"""Every kind of bad file, one by one and together with good ones: reported, skipped, listed at the end."""

from __future__ import annotations

import json
import struct
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

from shapegoogle_core.cli import main
from shapegoogle_core.library.library import Library

TRIANGLE = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
SQUARE = "OFF\n4 2 0\n0 0 0\n{} 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n"


def truncated(suffix: str) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        content = trimesh.creation.icosphere(2).export(file_type=suffix)
        path.write_bytes(content[: len(content) * 2 // 3])

    return write


def text(content: str) -> Callable[[Path], object]:
    return lambda path: path.write_text(content)


def million_faces(count: int) -> Callable[[Path], None]:
    """A binary STL of which the disk holds only the header: the rest is a hole, read as zeros."""

    def write(path: Path) -> None:
        with path.open("wb") as file:
            file.write(bytes(80) + struct.pack("<I", count))
            file.truncate(84 + 50 * count)

    return write


# Name of the file, how to write it, what the message must say beside the name.
BAD_FILES: list[tuple[str, Callable[[Path], object], str]] = [
    ("empty.obj", text(""), "empty"),
    ("truncated.stl", truncated("stl"), "cut short"),
    ("truncated.ply", truncated("ply"), "cut short"),
    ("truncated.glb", truncated("glb"), "cut short"),
    ("wrong_extension.ply", text(TRIANGLE), ".off"),
    ("not_a_number.off", text(SQUARE.format("nan")), "NaN or infinite"),
    ("infinite.off", text(SQUARE.format("inf")), "NaN or infinite"),
    ("points.obj", text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\n"), "no faces"),
    ("three_vertices.off", text(TRIANGLE), "at least 4"),
    ("coincident.off", text("OFF\n5 2 0\n" + "1 2 3\n" * 5 + "3 0 1 2\n3 2 3 4\n"), ""),
    ("no_area.off", text("OFF\n4 2 0\n0 0 0\n1 0 0\n2 0 0\n3 0 0\n3 0 1 2\n3 1 2 3\n"), ""),
    (
        "index_out_of_range.off",
        text("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 1\n3 0 1 7\n"),
        "has '3 0 1 7' in line 7, where a polygon of the vertices 0 to 3 is expected",
    ),
]
if sys.platform == "linux":  # elsewhere a process has no memory limit
    BAD_FILES.append(("ten_million_faces.stl", million_faces(10_000_000), "more than 512 MB of memory"))


@pytest.fixture
def batch(folder: Path) -> Path:
    for name, write, _ in BAD_FILES:
        write(folder / name)
    return folder


def test_a_batch(
    batch: Path, library: Library, library_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "no meshes").mkdir()
    inputs = [tmp_path / "nowhere", tmp_path / "no meshes", batch]
    arguments = [
        "index",
        *map(str, inputs),
        "--library",
        str(library_file),
        "--memory-limit",
        "512",
        "--json",
    ]
    assert main([*arguments, "--jobs", "1"]) == 1
    printed = capsys.readouterr()

    assert sorted(shape.name for shape in library.shapes()) == ["apple.off", "pear.obj", "plum.stl"]
    record = json.loads(printed.out)
    assert (record["added"], record["shapes"]) == (3, 3)
    reasons = {failure["source"]: failure["error"] for failure in record["failed"]}
    expected = [(str(batch / name), fault) for name, _, fault in BAD_FILES]
    expected += [(str(inputs[0]), "does not exist"), (str(inputs[1]), "has no mesh files")]
    assert set(reasons) == {source for source, _ in expected}
    for source, fault in expected:
        assert f"'{Path(source).name}'" in reasons[source]
        assert fault in reasons[source]

    # Each is named when it fails and once more in the list at the end.
    during, end = printed.err.split(f"{len(expected)} inputs failed:\n")
    for source, reason in reasons.items():
        assert f"skipped {source}: {reason}\n" in during
        assert f"  {source}: {reason}\n" in end
    assert "Traceback" not in printed.err

    # The next run tells the same without reading them again.
    assert main([*arguments, "--jobs", "1"]) == 1
    record = json.loads(capsys.readouterr().out)
    assert (record["added"], record["unchanged"]) == (0, 3)
    assert {failure["source"] for failure in record["failed"]} == set(reasons)


def test_as_queries(
    indexed: Library, batch: Path, library_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # Not the largest: queries are read in this process, which has no limit of its own.
    bad = [(batch / name, fault) for name, _, fault in BAD_FILES if name != "ten_million_faces.stl"]
    good = batch / "apple.off"
    queries = [good, *(path for path, _ in bad), good]
    assert main(["query", *map(str, queries), "--library", str(library_file), "--json"]) == 1
    printed = capsys.readouterr()
    records = [json.loads(line) for line in printed.out.splitlines()]
    assert [record["query"] for record in records] == list(map(str, queries))
    for record, (path, fault) in zip(records[1:-1], bad, strict=True):
        assert record["matches"] == []
        assert path.name in record["error"]
        assert fault in record["error"]
        assert f"  {path}: {record['error']}\n" in printed.err
    for record in (records[0], records[-1]):
        assert record["matches"][0]["name"] == "apple.off"
    assert "Traceback" not in printed.err


def test_only_a_missing_folder(
    library_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["index", str(tmp_path / "nowhere"), "--library", str(library_file)]) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert f"1 input failed:\n  {tmp_path / 'nowhere'}: 'nowhere' does not exist" in printed.err
    assert not library_file.exists()
