# SPDX-License-Identifier: MIT
"""`shapegoogle decisions` lists decisions and takes them back."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
import trimesh

import shapegoogle_core as sg
from shapegoogle_core.cli import main


@pytest.fixture
def library(tmp_path: Path) -> Iterator[sg.Library]:
    with sg.Library.open(tmp_path / "shapes.sglib") as opened:
        for size in (1, 2):
            opened.add(trimesh.creation.box((1, 1, size)), name=f"box {size}")
        yield opened


def test_decisions_are_listed_and_undone(library: sg.Library, capsys: pytest.CaptureFixture[str]) -> None:
    place = ["--library", str(library.path)]
    assert main(["decisions", *place]) == 0
    assert capsys.readouterr().err == "nothing was decided yet\n"
    library.decide("keep both", 1, 2, author="ana")
    library.decide("tag", 1, tag="crate")
    assert main(["decisions", *place]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert "ana" in first
    assert first.endswith("keep both 'box 1' and 'box 2'")
    assert second.endswith("'box 1' has the tag 'crate'")
    assert main(["decisions", *place, "--json"]) == 0
    assert [json.loads(line)["kind"] for line in capsys.readouterr().out.splitlines()] == ["keep both", "tag"]
    assert main(["decisions", *place, "--undo", "1"]) == 0
    assert capsys.readouterr().out.startswith("undone: 1")
    assert [decision.kind for decision in library.decisions()] == ["tag"]
    assert main(["decisions", *place, "--undo", "1"]) == 2
    assert "has no decision 1" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["decisions", "--undo", "1"], ["forget", "a"], ["move", "a", "b"]])
def test_a_misspelt_library_is_not_made(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    path = tmp_path / "misspelt.sglib"
    assert main([*command, "--library", str(path)]) == 2
    assert capsys.readouterr().err.startswith(f"shapegoogle: there is no library '{path}'; check the name")
    assert not path.exists()
