# SPDX-License-Identifier: MIT
"""The speed comparison measures and reports; its numbers mean nothing at this size."""

import json

import pytest

from benchmarks.speed import command, search
from benchmarks.speed.measuring import Contestant, race


def test_times_spectra_and_writes_a_report(tmp_path, capsys):
    arguments = ["--sections", "spectra", "--sizes", "600", "--repeats", "1", "--output", str(tmp_path)]
    assert command.run(command.parse_arguments(arguments)) == 0
    printed = capsys.readouterr().out
    assert "shapegoogle, robust" in printed
    report = json.loads((tmp_path / "speed-spectra.json").read_text())
    assert report["packages"]["numpy"]
    rows = {(row["task"], row["contestant"]): row for row in report["rows"]}
    assert {task for task, _ in rows} == {"k = 100", "k = 200"}
    ours = rows["k = 100", "shapegoogle"]
    assert ours["ratio"] == 1
    assert ours["size"] == pytest.approx(600, rel=0.02)
    assert ours["cpu_seconds"] > 0
    checked = [row for row in report["rows"] if row["contestant"] != "shapegoogle, robust"]
    assert all(row["error"] < 1e-8 for row in checked)
    # LaPy is among the packages that tests need.
    assert ("k = 100", "LaPy") in rows
    assert (tmp_path / "speed-spectra.png").stat().st_size > 10_000


def test_a_section_that_fails_does_not_stop_the_others(tmp_path, capsys, monkeypatch):
    def fail(options):
        raise OSError("the disk is full")

    monkeypatch.setattr(search, "measure", fail)
    arguments = ["--sections", "search,describing", "--sizes", "800", "--repeats", "1", "--output"]
    assert command.run(command.parse_arguments([*arguments, str(tmp_path)])) == 1
    printed = capsys.readouterr()
    assert '"format": ".ply"' in printed.out
    assert "the disk is full" in printed.err
    assert "the section 'search' failed" in printed.err
    names = sorted(entry.name for entry in tmp_path.iterdir())
    assert names == ["speed-describing.json", "speed-describing.png"]


def test_contestants_take_turns():
    turns = []
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
def test_wrong_usage(arguments, message, capsys):
    with pytest.raises(SystemExit) as caught:
        command.parse_arguments(arguments)
    assert caught.value.code == 2
    assert message in capsys.readouterr().err
