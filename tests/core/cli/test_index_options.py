# SPDX-License-Identifier: MIT
"""Options of `index` for whoever runs it every night: leaving files out, trying it out, a log."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.cli import main
from shapegoogle_core.indexing import ExternalReader
from shapegoogle_core.library.library import Library
from tests.core.cli.running import without_progress
from tests.core.number_reader import write_numbers

Run = Callable[..., tuple[int, str, str]]
LINE = re.compile(r"(\S+) (INFO|WARNING|ERROR) +(.*)")


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], library_file: Path) -> Run:
    def call(*arguments: object) -> tuple[int, str, str]:
        capsys.readouterr()
        code = main(["index", *map(str, arguments), "--library", str(library_file), "--jobs", "1"])
        printed = capsys.readouterr()
        return code, printed.out, without_progress(printed.err)

    return call


def state(folder: Path) -> dict[str, tuple[int, int, bytes]]:
    """All files below a folder, with their times and contents."""
    return {
        str(path): (path.stat().st_mtime_ns, path.stat().st_size, path.read_bytes())
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_excluding(run: Run, library: Library, folder: Path) -> None:
    code, stdout, stderr = run(folder, "--exclude", "p*.obj", "--exclude", "more/")
    assert (code, stderr) == (0, "")
    assert stdout.startswith("1 shape added from 1 file, 2 files and folders excluded; took ")
    assert [shape.name for shape in library.shapes()] == ["apple.off"]
    # What has been indexed stays when it is excluded later.
    code, stdout, stderr = run(folder, "--exclude", "apple*", "--prune", "--json")
    assert code == 0
    assert json.loads(stdout)["excluded"] == [str(folder / "apple.off")]
    assert stderr == "1 excluded file indexed before, which stay in the library\n"
    assert len(library) == 3
    code, stdout, _ = run(folder, "--exclude", "*")
    assert code == 0
    assert stdout == "nothing to do: 3 files and folders excluded; the library has 3 shapes\n"


def test_patterns_that_mean_nothing(run: Run, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        run(folder, "--exclude", "!a.obj")
    assert stop.value.code == 2
    assert "must not begin with '!'" in capsys.readouterr().err


def test_a_dry_run_of_a_new_library(
    run: Run, library_file: Path, folder: Path, make_mesh: Callable[..., Path]
) -> None:
    library_file.unlink(missing_ok=True)
    before = state(library_file.parent)
    code, stdout, stderr = run(folder, folder / "gone.obj", "--exclude", "more", "--dry-run")
    assert code == 1
    assert stdout.splitlines() == [
        f"add        {folder / 'apple.off'}",
        f"add        {folder / 'pear.obj'}",
        f"leave out  {folder / 'more'}",
        "dry run, nothing was changed: 2 files to add, 1 file to leave out, 1 input skipped",
    ]
    assert stderr.endswith("'gone.obj' does not exist; check the spelling\n")
    assert not library_file.exists()
    assert state(library_file.parent) == before


def test_a_dry_run_does_what_a_run_then_does(
    run: Run, indexed: Library, library_file: Path, folder: Path, make_mesh: Callable[..., Path]
) -> None:
    (folder / "broken.off").write_text("OFF\n")
    make_mesh(folder / "gone.off", seed=9)
    run(folder)
    make_mesh(folder / "pear.obj", seed=7)
    make_mesh(folder / "new.off", seed=8)
    os.utime(folder / "apple.off", ns=(1, 1))  # touched, but not changed
    (folder / "gone.off").unlink()
    indexed.close()
    before = state(library_file.parent)
    arguments = (folder, "--prune", "--json")
    code, stdout, _ = run(*arguments, "--dry-run")
    planned = json.loads(stdout)
    assert state(library_file.parent) == before
    assert planned["dry_run"]
    assert planned["added"] == [str(folder / "new.off")]
    assert planned["updated"] == [str(folder / "pear.obj")]
    assert planned["unchanged"] == [str(folder / "apple.off"), str(folder / "more" / "plum.stl")]
    assert planned["removed"] == [str(folder / "gone.off")]
    assert "found in an earlier run" in planned["failed"][0]["error"]
    done_code, stdout, _ = run(*arguments)
    done = json.loads(stdout)
    assert done_code == code == 1
    for status in ("added", "updated", "unchanged"):
        assert done[status] == len(planned[status])
    assert (done["removed"], done["failed"]) == (planned["removed"], planned["failed"])
    # With the options that read more again, all of it is listed.
    planned = json.loads(run(*arguments, "--dry-run", "--reread", "--retry")[1])
    assert (len(planned["added"]), len(planned["updated"])) == (1, 4)


def entries(log: Path) -> list[tuple[str, str]]:
    """Level and text of each line of a log; the lines of tracebacks are left out."""
    lines = [line for line in log.read_text(encoding="utf-8").splitlines() if not line.startswith("    ")]
    found = []
    for line in lines:
        match = LINE.fullmatch(line)
        assert match is not None, line
        assert abs(datetime.now().astimezone() - datetime.fromisoformat(match[1])) < timedelta(days=1)
        found.append((match[2], match[3]))
    return found


def test_log(
    library: Library, library_file: Path, folder: Path, tmp_path: Path, reader: ExternalReader
) -> None:
    log = tmp_path / "run.log"
    write_numbers(folder, "two", "1 2")
    write_numbers(folder, "cra\nsh", "crash")
    points = np.random.default_rng(0).normal(size=(300, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    np.savetxt(folder / "nan.xyz", [*points, [np.nan] * 3])
    arguments = [
        "index",
        str(folder),
        "--library",
        str(library_file),
        "--log",
        str(log),
        "--exclude",
        "pear*",
    ]
    assert main([*arguments, "--jobs", "1"], reader=reader) == 1
    found = entries(log)
    assert found[0][0] == "INFO"
    assert found[0][1].startswith("started: shapegoogle 0.")
    assert f"index {folder} --library {library_file} --log {log} --exclude 'pear*' --jobs 1" in found[0][1]
    assert found[-1][1].startswith("finished in ")
    assert "1 file or folder excluded" in found[-1][1]
    assert ("INFO", f"excluded {folder / 'pear.obj'}") in found
    levels = {text.split(" in ")[0]: level for level, text in found}
    assert levels[f"added {folder / 'two.numbers'} (2 shapes)"] == "INFO"
    assert [level for level, text in found if text.startswith(f"failed {folder}/cra\\nsh.numbers: ")] == [
        "ERROR"
    ]
    assert (
        [text for level, text in found if level == "WARNING"]
        == [text for _, text in found if text.startswith(f"{folder / 'nan.xyz'}: ")]
        != []
    )
    # The next run is appended.
    assert main(arguments, reader=reader) == 1
    again = entries(log)
    assert again[: len(found)] == found
    assert [text for _, text in again[len(found) :]].count(f"unchanged {folder / 'two.numbers'}") == 1


def test_an_unexpected_error_is_in_the_log(
    run: Run, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise LookupError("nobody foresaw this")

    monkeypatch.setattr(Library, "missing", fail)
    with pytest.raises(LookupError):
        run(folder, "--log", tmp_path / "run.log")
    assert entries(tmp_path / "run.log")[-1] == ("ERROR", "ended by an unexpected error")
    assert "    LookupError: nobody foresaw this" in (tmp_path / "run.log").read_text()


def test_errors_before_the_run_are_in_the_log(run: Run, folder: Path, library_file: Path) -> None:
    library_file.write_text("This is no database, whatever its name may say. " * 50)
    log = library_file.with_name("run.log")
    assert run(folder, "--log", log)[0] == 2
    level, text = entries(log)[-1]
    assert level == "ERROR"
    assert "not an SQLite database" in text


def test_files_that_are_no_log(run: Run, indexed: Library, library_file: Path, folder: Path) -> None:
    binary = folder / "picture.png"
    binary.write_bytes(b"\x89PNG\0\0")
    cases = [
        (folder, "is a folder"),
        (folder / "nowhere" / "run.log", "cannot be written"),
        (folder / "new.obj", "has the name of a mesh file"),
        (library_file, "is a file that this run reads or writes"),
        (binary, "is no text"),
    ]
    before = state(folder.parent)
    for log, fault in cases:
        code, stdout, stderr = run(folder, "--reread", "--log", log)
        assert (code, stdout) == (2, ""), log
        assert stderr.startswith(f"shapegoogle: the log '{log}' ")
        assert fault in stderr
    assert state(folder.parent) == before


@pytest.mark.skipif(sys.platform != "linux", reason="a device that is always full")
def test_a_log_on_a_full_disk_does_not_end_the_run(run: Run, library: Library, folder: Path) -> None:
    code, stdout, stderr = run(folder, "--log", "/dev/full")
    assert code == 0
    assert stdout.startswith("3 shapes added")
    assert stderr == (
        "warning: the log '/dev/full' can no longer be written: No space left on device; the run goes on\n"
    )
