# SPDX-License-Identifier: MIT
"""Progress of indexing: lines in a log, failed files, events for another program."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from shapegoogle_core.cli import index_progress
from shapegoogle_core.cli.index_progress import IndexProgress
from shapegoogle_core.indexing import FileOutcome
from tests.core.cli.running import without_progress

Capture = pytest.CaptureFixture[str]

OUTCOMES = [
    FileOutcome(Path("a.off"), "added"),
    FileOutcome(Path("b.off"), "failed", "'b.off' is damaged", "Traceback of b"),
    FileOutcome(Path("c.off"), "unchanged"),
]


def show(capsys: Capture, *, verbose: bool = False, events: bool = False) -> tuple[str, str]:
    with IndexProgress(3, verbose=verbose, events=events) as progress:
        for outcome in OUTCOMES:
            progress(outcome)
        assert progress.done == 3
    printed = capsys.readouterr()
    return printed.out, printed.err


def test_failed_files_are_shown_when_they_fail(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(index_progress, "SECONDS_BETWEEN_LINES", float("inf"))
    assert show(capsys) == ("", "skipped b.off: 'b.off' is damaged\n")
    assert show(capsys, verbose=True)[1] == "skipped b.off: 'b.off' is damaged\nTraceback of b\n"


def test_lines_in_a_log(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(index_progress, "SECONDS_BETWEEN_LINES", 0.0)
    _, stderr = show(capsys)
    lines = stderr.splitlines()
    assert [line.split(",")[0] for line in lines] == [
        "1 of 3 files",
        "skipped b.off: 'b.off' is damaged",
        "2 of 3 files",
        "3 of 3 files",
    ]
    assert lines[-1].endswith(" per second, 1 failed")
    assert without_progress(stderr) == "skipped b.off: 'b.off' is damaged\n"


def test_events(capsys: Capture) -> None:
    events = [json.loads(line) for line in show(capsys, events=True)[0].splitlines()]
    assert [event["done"] for event in events] == [1, 2, 3]
    assert events[1] == {
        "done": 2,
        "total": 3,
        "path": "b.off",
        "status": "failed",
        "reason": "'b.off' is damaged",
    }
