# SPDX-License-Identifier: MIT
"""Shares of right suggestions, and the picture of what some things find."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
import trimesh
from PIL import Image

from benchmarks import command


@pytest.fixture(scope="module")
def packs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three rods in one pack, and two rings and a ball in another."""
    folder = tmp_path_factory.mktemp("packs")
    solids = [
        *(("sticks", f"Rod{number}", trimesh.creation.cylinder(1, 5 + number)) for number in (1, 2, 3)),
        *(("jewels", f"Ring{number}", trimesh.creation.torus(2, 0.2 + number / 50)) for number in (1, 2)),
        ("jewels", "Pearl", trimesh.creation.icosphere(2)),
    ]
    with (folder / "meshes.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["file", "pack", "shape", "pose"])
        for pack, name, solid in solids:
            solid.export(folder / f"{pack}-{name}.ply")
            writer.writerow([f"{pack}-{name}.ply", pack, f"{pack}-{name}", 0])
    return folder


def test_shares_of_right_suggestions(packs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--blend-meshes", str(packs), "--cache", str(packs / "cache"), "--relatives", "1"]
    assert command.main(["suggestions", *options]) == 0
    _, *rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    counts = {row[0]: row[1:4] + row[8:9] for row in rows}
    # Shapes; how many of their folders can be right, and are; how many words can be right.
    assert counts["sticks"][:2] == ["3", "3"]
    assert counts["sticks"][2] == "100"
    assert counts["jewels"][:2] == ["3", "3"]
    assert counts["all"][:2] == ["6", "6"]
    assert [counts[pack][3] for pack in ("sticks", "jewels", "all")] == ["3", "2", "5"]


def test_picture_of_what_some_things_find(packs: Path, tmp_path: Path) -> None:
    output = tmp_path / "kinds.png"
    options = ["--blend-meshes", str(packs), "--cache", str(packs / "cache"), "--things", "2"]
    assert command.main(["kinds-picture", *options, "--output", str(output)]) == 0
    with Image.open(output) as picture:
        width, height = picture.size
    assert width > 600
    assert height > 250
