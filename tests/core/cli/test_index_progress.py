# SPDX-License-Identifier: MIT
"""Progress of indexing: lines in a log, failed files, events for another program."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from shapegoogle_core.cli import index_progress
from shapegoogle_core.cli.events import (
    CommandError,
    Event,
    StepProgress,
    event_from_json,
    event_to_json,
    summary_to_json,
)
from shapegoogle_core.cli.index_progress import IndexProgress
from shapegoogle_core.cli.steps import StepReporter
from shapegoogle_core.indexing import FileOutcome, IndexingProgress, IndexSummary
from shapegoogle_core.mesh.io.other_formats import SkippedFormat
from tests.core.cli.running import without_progress

Capture = pytest.CaptureFixture[str]

OUTCOMES = [
    FileOutcome(Path("a.off"), "added", shapes=12, seconds=0.5, warnings=("'a.off' has no unit",)),
    FileOutcome(Path("b.off"), "failed", "'b.off' is damaged", "Traceback of b"),
    FileOutcome(Path("c\udcff\n.off"), "unchanged"),
]
STATUS = [
    IndexingProgress(1, 3, 100, 2300, 5, 7, 40, seconds=60, seconds_left=180),
    IndexingProgress(2, 3, 1100, 2300),
    IndexingProgress(3, 3, 2300, 2300, 52, 0, 0, seconds=200, seconds_left=0),
]
SUMMARY = IndexSummary(
    added=12,
    updated=1,
    unchanged=2000,
    added_shapes=130,
    updated_shapes=1,
    partial_shapes=4,
    failed=(("b.off", "'b.off' is damaged"),),
    warnings=(("a.off", "'a.off' has no unit"),),
    removed=("gone.off",),
    excluded=("a_draft.off", "old"),
    skipped=(SkippedFormat("FBX", 1, "convert"), SkippedFormat("STEP", 12, "export")),
    library_shapes=2134,
    seconds=1.5,
)


def show(capsys: Capture, *, verbose: bool = False) -> tuple[str, list[Event]]:
    events: list[Event] = []
    with IndexProgress(3, verbose=verbose, send=events.append) as progress:
        for outcome, status in zip(OUTCOMES, STATUS, strict=True):
            progress.outcome(outcome)
            progress.status(status)
        assert progress.done == 3
    printed = capsys.readouterr()
    assert printed.out == ""
    return printed.err, events


def test_failed_files_are_shown_when_they_fail(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(index_progress, "SECONDS_BETWEEN_LINES", float("inf"))
    stderr, events = show(capsys)
    assert stderr == "warning: a.off: 'a.off' has no unit\nskipped b.off: 'b.off' is damaged\n"
    assert events[::2] == OUTCOMES
    assert events[1::2] == STATUS
    assert show(capsys, verbose=True)[0].endswith("skipped b.off: 'b.off' is damaged\nTraceback of b\n")


def test_lines_in_a_log(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(index_progress, "SECONDS_BETWEEN_LINES", 0.0)
    stderr, _ = show(capsys)
    assert stderr.splitlines() == [
        "warning: a.off: 'a.off' has no unit",
        "1 of 3 files, 5 of about 52 shapes, 3 min left, 0 failed",
        "skipped b.off: 'b.off' is damaged",
        "2 of 3 files, 0 shapes, estimating the time left, 1 failed",
        "3 of 3 files, 52 of 52 shapes, done, 1 failed",
    ]
    assert without_progress(stderr).splitlines() == [stderr.splitlines()[0], stderr.splitlines()[2]]


def test_the_open_scene_is_counted_in_shapes() -> None:
    status = IndexingProgress(0, 0, 0, 0, 3, 2, 35, seconds=2, seconds_left=20, scene=True)
    assert status.sentence() == "3 of about 40 shapes, 20 s left"
    assert replace(status, seconds_left=None).sentence() == "3 shapes, estimating the time left"
    done = IndexingProgress(0, 0, 0, 0, 40, seconds=22, seconds_left=0, scene=True)
    assert done.sentence() == "40 of 40 shapes, done"


def test_the_share_is_that_of_the_time() -> None:
    assert [status.share for status in STATUS] == [0.25, 0.0, 1.0]


@pytest.mark.parametrize(
    "event",
    [*OUTCOMES, *STATUS, SUMMARY, StepProgress("reading", 3, 12), CommandError("there is no library")],
)
def test_events_survive_their_way_through_json(event: Event) -> None:
    assert event_from_json(event_to_json(event)) == event


def test_the_summary_says_what_is_counted() -> None:
    assert SUMMARY.sentence() == (
        "130 shapes added from 12 files, 1 shape updated from 1 file, 2,000 files unchanged, 1 file removed, "
        "1 input failed (4 shapes stored), 2 files and folders excluded, 13 files not read (FBX, STEP), "
        "1 warning"
    )
    assert summary_to_json(SUMMARY)["new_shapes"] == 135
    assert IndexSummary(added=1, added_shapes=1, scene=True).sentence() == "1 shape of this scene"
    assert IndexSummary().sentence() == "no files found"


def test_steps_of_a_command(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shapegoogle_core.cli.steps.SECONDS_BETWEEN_EVENTS", 0.0)
    events: list[Event] = []
    assert list(StepReporter(events.append)("abc", "reading", 3)) == ["a", "b", "c"]
    assert events == [StepProgress("reading", done, 3) for done in range(3)]
    assert StepProgress("reading", 1200, 3000).sentence() == "reading: 1,200 of 3,000"
    assert list(StepReporter(None)("abc", "reading")) == ["a", "b", "c"]
    assert len(events) == 3
