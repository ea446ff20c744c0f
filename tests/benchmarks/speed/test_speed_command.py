# SPDX-License-Identifier: MIT
"""The speed comparison measures and reports; its numbers mean nothing at this size."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks import command
from benchmarks.speed import search, spectra
from benchmarks.speed.measuring import Contestant, Options, Row, race

Capture = pytest.CaptureFixture[str]


def main(arguments: list[str]) -> int:
    return command.main(["speed", *arguments])


@pytest.fixture(autouse=True)
def environment() -> Iterator[None]:
    """Undo the command's changes of environment variables."""
    before = dict(os.environ)
    yield
    os.environ.clear()
    os.environ.update(before)


@pytest.mark.long
def test_times_spectra_and_writes_a_report(tmp_path: Path, capsys: Capture) -> None:
    arguments = ["--sections", "spectra", "--sizes", "600", "--repeats", "1", "--output", str(tmp_path)]
    assert main(arguments) == 0
    printed = capsys.readouterr().out
    assert "shapegoogle, robust" in printed
    report = json.loads((tmp_path / "speed-spectra.json").read_text())
    assert report["packages"]["numpy"]
    rows = {(row["task"], row["contestant"]): row for row in report["rows"]}
    assert {task for task, _ in rows} == {"k = 10", "k = 20", "k = 100", "k = 200"}
    ours = rows["k = 100", "shapegoogle"]
    assert ours["ratio"] == 1
    assert ours["size"] == pytest.approx(600, rel=0.02)
    assert ours["cpu_seconds"] > 0
    checked = [row for row in report["rows"] if row["contestant"] != "shapegoogle, robust"]
    assert all(row["error"] < 1e-8 for row in checked)
    # LaPy is among the packages that tests need.
    assert ("k = 100", "LaPy") in rows
    assert (tmp_path / "speed-spectra.png").stat().st_size > 10_000


def test_a_section_that_fails_does_not_stop_the_others(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(options: Options) -> None:
        raise OSError("the disk is full")

    def one_row(options: Options) -> Iterator[Row]:
        yield {"task": "k = 1", "size": options.sizes[0], "contestant": "nobody", "cpu_seconds": 0.5}

    monkeypatch.setattr(search, "measure", fail)
    monkeypatch.setattr(spectra, "measure", one_row)
    arguments = ["--sections", "search,spectra", "--sizes", "800", "--repeats", "1", "--output"]
    assert main([*arguments, str(tmp_path)]) == 1
    printed = capsys.readouterr()
    assert '"contestant": "nobody"' in printed.out
    assert "the disk is full" in printed.err
    assert "the section 'search' failed" in printed.err
    names = sorted(entry.name for entry in tmp_path.iterdir())
    assert names == ["speed-spectra.json", "speed-spectra.png"]


def test_contestants_take_turns() -> None:
    turns: list[str] = []
    contestants = [
        Contestant("first", lambda: turns.append("first")),
        Contestant("second", lambda: turns.append("second"), lambda result: 0.5),
    ]
    first, second = race("task", 7, contestants, repeats=2)
    assert turns == ["first", "second"] * 2
    assert (first["ratio"], first["error"], second["error"]) == (1, None, 0.5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--sections", "spectra,magic"], "there is no section 'magic'; choose from spectra"),
        (["--sizes", "100,-3"], "'-3' is not a number above 0"),
        (["--repeats", "none"], "'none' is not a number above 0"),
    ],
)
def test_wrong_usage(arguments: list[str], message: str, capsys: Capture) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert message in capsys.readouterr().err
