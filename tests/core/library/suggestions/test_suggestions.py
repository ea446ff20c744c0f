# SPDX-License-Identifier: MIT
"""Suggestions: words of names, votes of relatives, and the method and command that show them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import trimesh

from shapegoogle_core.cli.parser import main
from shapegoogle_core.library.filter import Filter
from shapegoogle_core.library.library import Library
from shapegoogle_core.library.storage.records import ShapeRecord
from shapegoogle_core.library.suggestions import name_words, suggestions_from


def record(name: str, *, source: str = "", tags: tuple[str, ...] = ()) -> ShapeRecord:
    return ShapeRecord(1, name, source, "", 8, 12, 1.0, tags=tags)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("OfficeChair.blend", ["office", "chair"]),
        ("pine tree 04_LOD2", ["pine", "tree"]),
        ("USBStick", ["usb", "stick"]),
        ("Tür.001", ["tür"]),
        ("стул_новый", ["стул", "новый"]),
        ("chair_chair", ["chair"]),
        ("m1042.ply", []),
        ("", []),
    ],
)
def test_words_of_names(name: str, words: list[str]) -> None:
    assert name_words(name) == words


def test_relatives_vote_with_weights_by_distance() -> None:
    relatives = [
        record("Chair1", source="/models/furniture/Chair1.obj", tags=("wood",)),
        record("Chair2", source="/models/furniture/Chair2.obj"),
        record("Sword", source="/models/weapons/Sword.obj", tags=("metal",)),
    ]
    found = {(one.kind, one.text): one for one in suggestions_from(relatives, [0.1, 0.1, 0.4])}
    chair = found["word", "chair"]
    assert chair.relatives == ("Chair1", "Chair2")
    assert found["folder", "furniture"].confidence == chair.confidence
    assert chair.confidence > found["tag", "wood"].confidence > found["tag", "metal"].confidence > 0
    assert all(one.confidence < 1 for one in found.values())


def test_one_relative_is_less_certain_than_three_that_agree() -> None:
    alone = suggestions_from([record("vase")], [0.1])
    agreed = suggestions_from([record("vase")] * 3, [0.1, 0.1, 0.1])
    assert alone[0].confidence < agreed[0].confidence
    assert suggestions_from([], []) == []


@pytest.fixture(scope="module")
def library_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("suggest") / "shapes.sglib"
    with Library.open(path) as library:
        for number, length in enumerate((4, 5, 6)):
            library.add(trimesh.creation.cylinder(1, length), f"Pole{number}", tags=["long"])
        for number, width in enumerate((0.2, 0.25)):
            library.add(trimesh.creation.torus(2, width), f"Ring{number}", tags=["round"])
    return path


def test_a_shape_of_the_library_is_no_relative_of_its_own(library_file: Path) -> None:
    with Library.open(library_file, read_only=True) as library:
        first, *_ = found = library.suggest(1, relatives=2)
        assert (first.kind, first.text, first.relatives) == ("tag", "long", ("Pole1", "Pole2"))
        assert "Pole0" not in {name for one in found for name in one.relatives}
        only = library.suggest(1, where=Filter(tag="round"))
        assert {one.text for one in only} == {"round", "ring"}


def test_the_command(library_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh, empty = tmp_path / "new.obj", tmp_path / "empty.obj"
    trimesh.creation.torus(2, 0.22).export(mesh)
    empty.write_text("", encoding="utf-8")
    options = ["--library", str(library_file), "--relatives", "2"]
    assert main(["suggest", str(mesh), str(empty), *options, "--json"]) == 1
    good, bad = map(json.loads, capsys.readouterr().out.splitlines())
    assert {one["text"] for one in good["suggestions"]} == {"round", "ring"}
    assert good["query"] == str(mesh)
    assert (bad["query"], bad["suggestions"]) == (str(empty), [])
    assert "empty.obj" in bad["error"]
    assert main(["suggest", str(mesh), *options, "--top", "1"]) == 0
    title, header, row = capsys.readouterr().out.strip().splitlines()
    assert title == str(mesh)
    assert header.split() == ["confidence", "kind", "suggestion", "relatives", "that", "have", "it"]
    assert row.endswith(("Ring0, Ring1", "Ring1, Ring0"))
