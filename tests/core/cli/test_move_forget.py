# SPDX-License-Identifier: MIT
"""`shapegoogle move`, `forget` and `index --root`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from shapegoogle_core.cli.parser import main
from shapegoogle_core.library.library import Library

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run the command in this process: no file has to be described."""

    def call(*arguments: object) -> tuple[int, str, str]:
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return call


def test_a_folder_that_was_moved(run: Run, indexed: Library, library_file: Path, folder: Path) -> None:
    indexed.close()
    code, _, _ = run("index", "--root", f"fruit={folder}", "--library", library_file)
    assert code == 0
    new = folder.parent / "new"
    folder.rename(new)
    (new / "pear.obj").unlink()

    code, stdout, _ = run("move", folder, new, "--library", library_file, "--dry-run")
    assert (code, stdout.splitlines()) == (
        0,
        [
            f"root fruit: {folder} → {new}",
            "2 of 3 files found at the new place",
            f"  not there: {new / 'pear.obj'}",
            "dry run: nothing was changed",
        ],
    )
    code, stdout, stderr = run("index", new, "--library", library_file, "--json")
    assert json.loads(stdout)["shapes"] == 5
    assert f"the folder '{folder}' of the root 'fruit' is not there; if it was moved, run" in stderr
    code, stdout, _ = run("move", folder, new, "--library", library_file, "--json")
    record = json.loads(stdout)
    assert (code, record["found"], len(record["merged"]), record["dry_run"]) == (0, 2, 2, False)

    code, stdout, _ = run("info", "--library", library_file)
    assert f"new: {new} (3 sources)" in stdout
    code, _, stderr = run("move", folder, new, "--library", library_file)
    assert code == 2
    assert stderr.startswith(f"shapegoogle: no indexed file lies below '{folder}'; the library knows '{new}'")


def test_forgetting(run: Run, indexed: Library, library_file: Path, folder: Path) -> None:
    indexed.close()
    run("index", folder, "--library", library_file)
    code, stdout, _ = run("forget", folder / "more", "--library", library_file, "--dry-run")
    listed = ["1 source, 1 shape:", f"  {folder / 'more' / 'plum.stl'}"]
    assert (code, stdout.splitlines()) == (0, [*listed, "dry run: nothing was changed"])
    code, stdout, _ = run("forget", folder / "more", "--library", library_file)
    assert (code, stdout.splitlines()) == (0, [*listed, "forgotten"])

    code, stdout, _ = run("forget", "--missing", "--library", library_file)
    assert (code, stdout) == (0, "0 sources, 0 shapes to forget\n")
    away = folder.rename(folder.parent / "away")
    code, stdout, stderr = run("forget", "--missing", "--library", library_file, "--json")
    record = {"forgotten": [], "shapes": 0, "kept": {str(folder): 2}, "dry_run": False}
    assert (code, json.loads(stdout)) == (0, record)
    code, stdout, stderr = run("forget", "--missing", "--library", library_file)
    assert f"kept 2 missing files below '{folder}', which is not there or empty" in stderr
    code, _, stderr = run("forget", "nowhere", "--library", library_file)
    assert (code, stderr) == (
        2,
        "shapegoogle: 'nowhere' is no source of the library, and no indexed file lies below it; "
        "`shapegoogle info` lists its folders\n",
    )
    code, stdout, _ = run("forget", folder, "--library", library_file, "--json")
    assert json.loads(stdout)["shapes"] == 2
    assert away.is_dir()
    assert run("forget", "--library", library_file)[0] == 2


def test_wrong_roots(run: Run, folder: Path, library_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for value in ("fruit", "=", f"={folder}", "fruit=nowhere"):
        with pytest.raises(SystemExit):
            run("index", "--root", value, "--library", library_file)
        assert "--root" in capsys.readouterr().err
    assert run("index", "--library", library_file)[0] == 2
    assert not library_file.exists()
