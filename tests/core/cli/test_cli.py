# SPDX-License-Identifier: MIT
"""The command from a user's side: what it prints, where, and how it ends."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.cli import main
from shapegoogle_core.library.library import Library
from tests.core.cli.running import Shapegoogle, StartShapegoogle, without_progress

Command = Callable[..., tuple[int, str, str]]
"""Runs the command in this process: exit code, stdout, stderr."""


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Command:

    def call(*arguments: object) -> tuple[int, str, str]:
        capsys.readouterr()
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as exit:  # argparse
            code = exit.code if isinstance(exit.code, int) else 1
        printed = capsys.readouterr()
        return code, printed.out, without_progress(printed.err)

    return call


def test_help_and_version(run: Command) -> None:
    code, text, _ = run("--help")
    assert code == 0
    for part in ("index", "query", "info", "train", "exit codes:", "examples:"):
        assert part in text
    for command in ("index", "query", "info", "train"):
        code, text, _ = run(command, "--help")
        assert (code, "exit codes:" in text) == (0, True)
    code, text, _ = run("--version")
    assert code == 0
    assert text.startswith("shapegoogle 0.")


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["search"],
        ["index", "--library", "x"],
        ["index", "folder"],
        ["index", "folder", "--library", "x", "--jobs", "0"],
        ["index", "folder", "--library", "x", "--jobs", "two"],
        ["index", "folder", "--library", "x", "--time-limit", "-1"],
        ["index", "folder", "--library", "x", "--time-limit", "nan"],
        ["query", "--library", "x"],
        ["query", "mesh.obj", "--library", "x", "--top", "0"],
        ["query", "mesh.obj", "--library", "x", "--unlike"],
        ["query", "--together", "--library", "x"],
        ["query", "mesh.obj", "--library", "x", "--name", " "],
        ["query", "mesh.obj", "--library", "x", "--faces", "1000"],
        ["query", "mesh.obj", "--library", "x", "--faces", "5000:1000"],
        ["query", "mesh.obj", "--library", "x", "--size", ":"],
        ["query", "mesh.obj", "--library", "x", "--size", "1:wide"],
        ["query", "mesh.obj", "--library", "x", "--kind", "same"],
        ["query", "mesh.obj", "--library", "x", "--min-similarity", "1.5"],
        ["info"],
        ["train", "folder"],
    ],
)
def test_wrong_usage(run: Command, arguments: list[str]) -> None:
    code, stdout, stderr = run(*arguments)
    assert (code, stdout) == (2, "")
    assert stderr.startswith("usage: shapegoogle")


def test_the_module_is_the_command(shapegoogle: Shapegoogle) -> None:
    done = shapegoogle("info", "--library", "nowhere.sglib")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "shapegoogle: there is no library 'nowhere.sglib'; check the name, or index a folder into it first\n"
    )


def test_index_and_index_again(run: Command, library_file: Path, folder: Path, model_file: Path) -> None:
    arguments = ["index", folder, "--library", library_file, "--jobs", "1"]
    code, stdout, stderr = run(*arguments, "--model", model_file)
    assert (code, stderr) == (0, "")
    assert stdout.startswith("3 shapes added from 3 files; took ")
    assert stdout.endswith("the library has 3 shapes\n")
    # The library brings its model along.
    assert run(*arguments) == (0, "nothing to do: 3 files unchanged; the library has 3 shapes\n", "")


def test_index_as_json(run: Command, indexed: Library, library_file: Path, folder: Path) -> None:
    code, stdout, stderr = run("index", folder, folder / "gone.obj", "--library", library_file, "--json")
    assert code == 1
    record = json.loads(stdout)
    assert record.pop("seconds") >= 0
    assert record == {
        "added": 0,
        "updated": 0,
        "unchanged": 3,
        "removed": [],
        "excluded": [],
        "skipped": [],
        "left_out": {},
        "new_shapes": 0,
        "added_shapes": 0,
        "updated_shapes": 0,
        "warnings": [],
        "scene": False,
        "failed": [
            {"source": str(folder / "gone.obj"), "error": "'gone.obj' does not exist; check the spelling"}
        ],
        "shapes": 3,
    }
    assert stderr.count("gone.obj' does not exist") == 2


def test_files_of_other_formats_are_counted(run: Command, library_file: Path, tmp_path: Path) -> None:
    folder = tmp_path / "parts"
    folder.mkdir()
    for name in ("a.step", "b.STP", "notes.txt"):
        (folder / name).touch()
    sentence = "2 STEP files skipped: export from the CAD program as STL or 3MF, with a fine tolerance"
    code, stdout, stderr = run("index", folder, "--library", library_file, "--json")
    assert code == 1  # there is nothing else in the folder
    skipped = {"format": "STEP", "files": 2, "advice": sentence.partition(": ")[2]}
    assert json.loads(stdout)["skipped"] == [skipped]
    assert sentence in stderr.splitlines()
    assert sentence in run("index", folder, "--library", library_file, "--dry-run")[2].splitlines()


def test_what_was_left_out_of_a_file_is_said(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    path = folder / "pear.obj"
    with path.open("a") as file:
        file.write("v nan nan nan\n")
    sentence = (
        "'pear.obj' has 1 of 163 points without finite coordinates (NaN or infinite); they were left out"
    )
    code, stdout, stderr = run("index", folder, "--library", library_file, "--jobs", "1", "--json")
    assert (code, stderr) == (0, f"warning: {path}: {sentence}\n")
    assert json.loads(stdout)["warnings"] == [{"source": str(path), "warning": sentence}]
    code, stdout, stderr = run("query", path, "--library", library_file, "--top", "1", "--evidence", "0")
    assert (code, stderr) == (0, f"warning: {path}: {sentence}\n")


def test_prune(run: Command, indexed: Library, library_file: Path, folder: Path) -> None:
    (folder / "apple.off").unlink()
    # Nothing is forgotten unasked.
    code, stdout, _ = run("index", folder, "--library", library_file)
    assert (code, stdout) == (0, "nothing to do: 2 files unchanged; the library has 3 shapes\n")
    code, stdout, _ = run("index", folder, "--library", library_file, "--prune")
    assert code == 0
    assert stdout.startswith("2 files unchanged, 1 file removed; took ")
    assert len(indexed) == 2


def test_query_as_json(
    run: Command, indexed: Library, library_file: Path, folder: Path, tmp_path: Path
) -> None:
    queries = [folder / "pear.obj", tmp_path / "gone.obj", folder / "more" / "plum.stl"]
    code, stdout, stderr = run("query", *queries, "--library", library_file, "--json")
    assert code == 1
    records = [json.loads(line) for line in stdout.splitlines()]
    assert [record["query"] for record in records] == list(map(str, queries))
    for record in (records[0], records[2]):
        assert set(record) == {"query", "matches"}
        best = record["matches"][0]
        named = {"name", "source", "object_name"}
        assert set(best) == {
            *named,
            "similarity",
            "likeness",
            "distance",
            "evidence",
            "placements",
            "shape_type",
        }
        assert (best["source"], best["similarity"], best["distance"]) == (record["query"], 1.0, 0.0)
        assert best["name"] == Path(record["query"]).name
        distances = [match["distance"] for match in record["matches"]]
        # Fewer shapes than the ten asked for: all of them, best first.
        assert distances == sorted(distances)
        assert len(distances) == 3
    assert records[1]["matches"] == []
    assert records[1]["error"].startswith(f"'{queries[1]}' does not exist")
    assert stderr.startswith("1 input failed:\n  ")
    assert str(queries[1]) in stderr


def test_query_as_a_table(run: Command, indexed: Library, library_file: Path, folder: Path) -> None:
    query = folder / "pear.obj"
    code, stdout, stderr = run("query", query, "--library", library_file, "--top", "2", "--exact")
    assert (code, stderr) == (0, "")
    title, head, first, second, blank, *legend = stdout.splitlines()
    assert title == f"{query}: the best 2 of 3 shapes"
    assert head.split() == ["similarity", "likeness", "distance", "evidence", "name", "source"]
    assert first.split() == ["1", "1.000", "0.0000", "pear.obj", str(query)]
    assert second.split()[0] == "2"
    # Columns stand under their heads, and no path is cut off.
    assert first.index("pear.obj") == head.index("name")
    assert first.index(str(query)) == second.index(str(folder)) == head.index("source")
    assert blank == ""
    assert [line.split(":")[0] for line in legend] == ["similarity", "likeness", "distance", "evidence"]


def test_versions_of_a_match_are_listed_after_it(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    query = folder / "pear.obj"
    (pear,) = [shape for shape in indexed.shapes() if shape.name == "pear.obj"]
    indexed.add_signature(indexed.signature(pear.shape_id), "copy of the pear")
    code, stdout, _ = run("query", query, "--library", library_file, "--versions")
    assert code == 0
    # The bags of the tiny model make one family of all.
    title, _, first, version, *_ = stdout.splitlines()
    assert "the best 1 of 4 shapes" in title
    assert " and 3 versions" in first
    assert version.split()[:2] == ["1.1", "1.000"]
    assert ("copy of the pear" in first) != ("copy of the pear" in version)
    _, stdout, _ = run("query", query, "--library", library_file, "--versions", "--json")
    (match,) = json.loads(stdout)["matches"]
    names = [match["name"], *(version["name"] for version in match["version_matches"])]
    assert sorted(names[:2]) == ["copy of the pear", "pear.obj"]
    assert sorted(names[2:]) == ["apple.off", "plum.stl"]


@pytest.mark.parametrize(
    ("filters", "expected"),
    [
        (["--name", "PLUM"], ["plum.stl"]),
        (["--folder", "{folder}/more"], ["plum.stl"]),
        (["--faces", "1:"], ["apple.off", "pear.obj", "plum.stl"]),
        (["--file-type", "STL"], ["plum.stl"]),
        (["--faces", ":1"], []),
        (["--size", "1e6:"], []),
        (["--tag", "wood"], []),
        (["--min-similarity", "1"], ["pear.obj"]),
    ],
)
def test_query_with_filters(
    run: Command, indexed: Library, library_file: Path, folder: Path, filters: list[str], expected: list[str]
) -> None:
    options = [option.format(folder=folder) for option in filters]
    code, stdout, stderr = run("query", folder / "pear.obj", "--library", library_file, "--json", *options)
    assert (code, stderr) == (0, "")
    matches = json.loads(stdout)["matches"]
    assert sorted(match["name"] for match in matches) == sorted(expected)
    if not expected:
        _, stdout, _ = run("query", folder / "pear.obj", "--library", library_file, *options)
        assert "pear.obj: none of 3 shapes meets the filters" in stdout


def test_a_kind_cannot_be_found_without_samples(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    code, _, stderr = run("query", folder / "pear.obj", "--library", library_file, "--kind", "moved")
    assert code != 0
    assert "keeps no samples of surfaces to find the kind 'moved' with" in stderr


def test_meshes_together_are_one_query(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    meshes = [folder / "pear.obj", folder / "apple.off"]
    unlike = folder / "more" / "plum.stl"
    code, stdout, stderr = run(
        "query", *meshes, "--together", "--unlike", unlike, "--library", library_file, "--json"
    )
    assert (code, stderr) == (0, "")
    record = json.loads(stdout)
    assert list(record) == ["query", "unlike", "matches"]
    assert (record["query"], record["unlike"]) == (list(map(str, meshes)), [str(unlike)])
    assert [match["name"] for match in record["matches"]] == ["apple.off", "pear.obj", "plum.stl"]
    assert record["matches"][-1]["distance"] == 2
    code, stdout, _ = run("query", *meshes, "--together", "--library", library_file, "--json")
    record = json.loads(stdout)
    assert (record["unlike"], len(record["matches"])) == ([], 3)
    _, stdout, _ = run("query", *meshes, "--together", "--unlike", unlike, "--library", library_file)
    title = stdout.splitlines()[0]
    assert title == f"{meshes[0]} and {meshes[1]}, not like {unlike}: the best 3 of 3 shapes"
    assert stdout.splitlines()[-1].startswith("evidence:")


def test_what_is_not_looked_for_goes_with_every_query(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    meshes = [folder / "pear.obj", folder / "apple.off"]
    unlike = folder / "more" / "plum.stl"
    _, stdout, _ = run("query", *meshes, "--library", library_file, "--json", "--unlike", unlike)
    records = [json.loads(line) for line in stdout.splitlines()]
    assert [record["query"] for record in records] == list(map(str, meshes))
    for record in records:
        assert list(record) == ["query", "unlike", "matches"]
        assert record["matches"][0]["source"] == record["query"]
        assert record["matches"][-1]["source"] == str(unlike)


def test_examples_that_cannot_be_read(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    """Without one of its examples it would be another question; each is named."""
    pear, gone, broken = folder / "pear.obj", folder / "gone.obj", folder / "broken.off"
    broken.write_text("OFF\n")
    options = ("--library", library_file, "--json")
    code, stdout, stderr = run("query", pear, gone, "--together", "--unlike", broken, *options)
    record = json.loads(stdout)
    assert (code, record["matches"]) == (1, [])
    assert record["query"] == [str(pear), str(gone)]
    assert "gone.obj' does not exist" in record["error"]
    assert "'broken.off'" in record["error"]
    assert stderr.startswith("2 inputs failed:\n")
    code, stdout, stderr = run("query", pear, pear, "--unlike", gone, *options)
    records = [json.loads(line) for line in stdout.splitlines()]
    assert (code, len(records)) == (1, 2)
    assert all("gone.obj' does not exist" in record["error"] for record in records)
    assert stderr.startswith("1 input failed:\n")
    code, stdout, _ = run("query", pear, "--unlike", gone, "--library", library_file)
    assert (code, stdout) == (1, "")


def test_query_of_an_empty_library(run: Command, library: Library, library_file: Path, folder: Path) -> None:
    code, stdout, _ = run("query", folder / "pear.obj", "--library", library_file, "--json")
    assert (code, json.loads(stdout)["matches"]) == (0, [])
    code, stdout, _ = run("query", folder / "pear.obj", "--library", library_file)
    assert code == 0
    assert "the library is empty" in stdout


def test_info(run: Command, indexed: Library, library_file: Path) -> None:
    code, stdout, _ = run("info", "--library", library_file, "--json")
    record = json.loads(stdout)
    assert code == 0
    assert (record["shapes"], record["model"]) == (3, indexed.model.identifier)
    assert record["bytes"] == library_file.stat().st_size
    code, stdout, _ = run("info", "--library", library_file)
    assert code == 0
    lines = [line.split() for line in stdout.splitlines()]
    for line in (["shapes", "3"], ["failed", "0"], ["model", indexed.model.identifier]):
        assert line in lines


def test_info_lists_what_failed(run: Command, indexed: Library, library_file: Path, folder: Path) -> None:
    (folder / "broken.off").write_text("OFF\n")
    assert run("index", folder, "--library", library_file, "--jobs", "1")[0] == 1
    _, stdout, _ = run("info", "--library", library_file, "--json")
    assert list(json.loads(stdout)["failures"]) == [str(folder / "broken.off")]
    _, stdout, _ = run("info", "--library", library_file)
    assert f"{folder / 'broken.off'}: 'broken.off'" in stdout


def test_files_that_are_gone_are_mentioned_and_kept(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    (folder / "pear.obj").unlink()
    _, _, stderr = run("index", folder, "--library", library_file, "--jobs", "1")
    assert "1 indexed file no longer there; remove with --prune" in stderr
    assert len(indexed) == 3


def test_library_and_model_that_cannot_be_used(
    run: Command, folder: Path, tmp_path: Path, model_file: Path
) -> None:
    text = tmp_path / "notes.txt"
    text.write_text("This is no database, whatever its name may say. " * 50)
    cases = [
        (["index", folder, "--library", tmp_path], "is a folder"),
        (["index", folder, "--library", text], "not an SQLite database"),
        (["query", folder / "pear.obj", "--library", text], "not an SQLite database"),
        (["info", "--library", tmp_path / "none.sglib"], "there is no library"),
        (["query", folder / "pear.obj", "--library", tmp_path / "none.sglib"], "there is no library"),
        (["index", folder, "--library", tmp_path / "no" / "folder.sglib"], "there is no folder"),
    ]
    if sys.platform == "linux":
        # Nobody may write there, not even root: as good as a read-only disk.
        cases.append((["index", folder, "--library", "/proc/shapes.sglib"], "cannot be created"))
    for arguments, fault in cases:
        code, stdout, stderr = run(*arguments)
        assert (code, stdout) == (2, ""), arguments
        assert stderr.startswith("shapegoogle: ")
        assert fault in stderr
        assert "Traceback" not in stderr
    code, _, stderr = run("info", "--library", tmp_path, "--verbose")
    assert code == 2
    assert "Traceback" in stderr


def test_damaged_model(
    run: Command, folder: Path, library_file: Path, model_file: Path, tmp_path: Path
) -> None:
    damaged = tmp_path / "damaged.npz"
    damaged.write_bytes(model_file.read_bytes()[:-200])
    code, stdout, stderr = run("index", folder, "--library", library_file, "--model", damaged)
    assert (code, stdout) == (2, "")
    assert stderr.startswith("shapegoogle: ")
    assert str(damaged) in stderr
    # No library is left behind that would have to be removed first.
    assert not library_file.exists()


def test_another_model_than_the_library_has(
    run: Command, indexed: Library, library_file: Path, folder: Path
) -> None:
    other = folder.parent / "other.npz"
    replace(indexed.model, mean=np.ones_like(indexed.model.mean)).save(other)
    code, _, stderr = run("index", folder, "--library", library_file, "--model", other)
    assert code == 2
    assert "was made with model" in stderr


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such pipes")
def test_a_reader_that_stops_reading(
    start_shapegoogle: StartShapegoogle, indexed: Library, library_file: Path, folder: Path
) -> None:
    """`shapegoogle query … | head -1`."""
    process = start_shapegoogle("query", *[folder / "pear.obj"] * 200, "--library", library_file, "--json")
    assert process.stdout is not None
    assert process.stderr is not None
    assert json.loads(process.stdout.readline())["query"] == str(folder / "pear.obj")
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait() == 141


def test_pruning_keeps_what_may_be_on_a_drive(
    run: Command, indexed: Library, library_file: Path, folder: Path, tmp_path: Path
) -> None:
    """A folder that is not there, and one that is empty, as a drive that is not plugged in leaves them."""
    (folder / "apple.off").unlink()
    (folder / "more").rename(tmp_path / "elsewhere")
    arguments = ("--library", library_file, "--prune", "--json")
    code, stdout, stderr = run("index", folder / "more", folder / "pear.obj", *arguments)
    assert (code, json.loads(stdout)["removed"]) == (1, [])
    assert "'more' does not exist" in stderr
    (folder / "more").mkdir()
    code, stdout, stderr = run("index", folder / "more", *arguments)
    assert (code, json.loads(stdout)["removed"]) == (1, [])
    assert "'more' has no mesh files" in stderr
    assert len(indexed) == 3


def test_json_without_any_file(run: Command, tmp_path: Path) -> None:
    library = tmp_path / "none.sglib"
    code, stdout, _ = run("index", tmp_path / "gone", "--library", library, "--json")
    record = json.loads(stdout)
    assert (code, record["added"], record["shapes"], len(record["failed"])) == (1, 0, 0, 1)
    assert not library.exists()
