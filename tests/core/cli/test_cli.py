# SPDX-License-Identifier: MIT
"""The command from a user's side: what it prints, where, and how it ends."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.library.library import Library
from tests.core.cli.running import Command, Shapegoogle


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
