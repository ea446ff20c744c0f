# SPDX-License-Identifier: MIT
"""The command as another program starts it: events on a pipe of their own, however long they are."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

from shapegoogle_core.cli.events import CommandError, event_from_json
from shapegoogle_core.indexing import FileOutcome, IndexSummary
from shapegoogle_core.library.library import Library
from shapegoogle_core.processes.program import Program
from tests.core.cli.running import command_line


def test_a_long_summary_arrives_whole(
    library: Library, library_file: Path, tmp_path: Path, make_mesh: Callable[..., Path]
) -> None:
    """All that is printed goes elsewhere, at the same time."""
    depth = 1 if sys.platform == "win32" else 8
    folder = tmp_path.joinpath("files", *["}\u2028{ long name of a folder " * 8] * depth)
    folder.mkdir(parents=True)
    for number in range(40):
        (folder / f"{number:02}.off").write_text("OFF\n")
    make_mesh(folder / "good.off")
    arguments = ("index", tmp_path / "files", "--library", library_file, "--json", "-v", "--jobs", "2")
    program = Program(command_line(*arguments))
    *events, summary = map(event_from_json, program.messages())
    assert program.wait() == 1
    assert isinstance(summary, IndexSummary)
    assert (summary.added, summary.added_shapes, len(summary.failed)) == (1, 1, 40)
    outcomes = [event for event in events if isinstance(event, FileOutcome)]
    assert {outcome.path for outcome in outcomes} == set(folder.iterdir())
    assert sys.platform == "win32" or len(json.dumps(summary.failed)) > 2**16
    # What is printed meanwhile has no lines that names have broken.
    assert program.last_lines(1).endswith("copy or export it again")
    assert "\u2028" not in program.last_lines(100)


def test_an_error_of_the_command_arrives_as_a_sentence(tmp_path: Path) -> None:
    program = Program(command_line("info", "--library", tmp_path / "no\nwhere.sglib"))
    (error,) = map(event_from_json, program.messages())
    assert program.wait() == 2
    assert isinstance(error, CommandError)
    assert error.reason.startswith("there is no library")
