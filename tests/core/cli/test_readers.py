# SPDX-License-Identifier: MIT
"""The command with a program that reads more kinds of files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from shapegoogle_core.cli import main
from shapegoogle_core.cli.events import event_from_json
from shapegoogle_core.indexing import ExternalReader, FileOutcome, IndexingProgress
from shapegoogle_core.library.library import Library
from shapegoogle_core.model import ShapeModel
from tests.core.number_reader import write_numbers


def test_command(
    reader: ExternalReader,
    model: ShapeModel,
    library_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    Library.open(library_file, model).close()
    path = write_numbers(tmp_path / "files", "two", "1 2")
    arguments = [
        "index",
        str(path.parent),
        "--library",
        str(library_file),
        "--jobs",
        "1",
        "--events",
        "--json",
    ]
    assert main([*arguments, "--prefix", "y"], reader=reader) == 0
    *events, summary = map(json.loads, capsys.readouterr().out.splitlines())
    (outcome,) = (event_from_json(event) for event in events if event["event"] == "file")
    assert isinstance(outcome, FileOutcome)
    assert (outcome.path, outcome.status, outcome.shapes) == (path, "added", 2)
    first, *_, last = (event_from_json(event) for event in events if event["event"] == "progress")
    assert isinstance(first, IndexingProgress)
    assert isinstance(last, IndexingProgress)
    assert (first.files_done, first.bytes_done, first.seconds_left) == (0, 0, None)
    assert (last.files_done, last.bytes_done, last.shapes_done) == (1, path.stat().st_size, 2)
    assert (last.share, last.seconds_left) == (1, 0)
    assert (summary["added"], summary["new_shapes"], summary["shapes"]) == (1, 2, 2)

    gone = str(tmp_path / "gone.numbers")
    query = ["query", str(path), gone, "--library", str(library_file), "--json", "--top", "1"]
    assert main(query, reader=reader) == 1
    first, second, third = map(json.loads, capsys.readouterr().out.splitlines())
    assert (first["query"], first["object"], first["matches"][0]["name"]) == (str(path), "x1", "y1")
    assert second["object"] == "x2"
    assert (third["query"], third["matches"]) == (gone, [])
    assert "is not there" in third["error"]
