# SPDX-License-Identifier: MIT
"""The comparison of readers: figures that do not depend on storage, verdicts, and a small folder."""

from __future__ import annotations

import csv
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import pytest
import trimesh

from benchmarks.command import main
from benchmarks.errors import BenchmarkError
from benchmarks.experiments.files.command import find_models
from benchmarks.experiments.files.facts import Facts, differences, measure, triangles_of_polygons
from benchmarks.experiments.files.gltf_at_rest import without_animations
from benchmarks.experiments.files.reading import BLENDER, PRODUCT, Reading, readers_of
from benchmarks.experiments.files.through_blender import find_blender
from benchmarks.experiments.files.verdicts import judge
from tests.core.mesh.io.mesh_files import AREA, FILES, POINTS, QUADS, TRIANGLES, glb, gltf_tree, write

BOX = Facts(8, 12, AREA, (0.0, 0.0, 0.0), (2.0, 1.0, 3.0))
# A square with a notch down to its middle, as one polygon; and a dart.
NOTCHED = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [1, 1, 0], [0, 2, 0]], np.float64)
DART = np.array([[0, 0, 0], [3, 0, 0], [1, 1, 0], [0, 3, 0]], np.float64)


class TestFacts:
    def test_a_box_however_it_is_stored(self) -> None:
        faces = np.array(TRIANGLES)
        soup = POINTS[faces].reshape(-1, 3) + 1e-8
        unused = np.concatenate([POINTS, [[9, 9, 9]]])
        twice = np.concatenate([faces, faces[:, [1, 2, 0]], [[0, 0, 1]]])
        assert measure(POINTS, faces) == BOX
        for vertices, triangles in (
            (soup, np.arange(36).reshape(-1, 3)),
            (unused, faces),
            (POINTS.astype(np.float32).astype(np.float64), twice),
        ):
            facts = measure(vertices, triangles, AREA)
            assert facts is not None
            assert not differences(facts, BOX)

    def test_points_and_nothing(self) -> None:
        no_faces = np.empty((0, 3), np.int64)
        assert measure(POINTS, no_faces) == Facts(8, 0, 0.0, BOX.lower, BOX.upper)
        assert measure(np.empty((0, 3)), no_faces) is None
        assert measure(POINTS * np.nan, np.array(TRIANGLES)) is None

    def test_differences_are_named(self) -> None:
        larger = Facts(8, 12, 2 * AREA, (0.0, 0.0, 0.0), (2.0, 1.0, 6.0))
        assert differences(BOX, larger) == {"area": 0.5, "extent": 0.5}
        assert differences(BOX, Facts(9, 14, AREA, BOX.lower, BOX.upper)).keys() == {"vertices", "faces"}

    @pytest.mark.parametrize(("polygon", "area"), [(NOTCHED, 3.0), (DART, 3.0)])
    def test_area_of_concave_polygons(
        self, polygon: np.ndarray[tuple[int, int], np.dtype[np.float64]], area: float
    ) -> None:
        for first in range(len(polygon)):
            corners = np.roll(np.arange(len(polygon)), first)[None]
            triangles, found = triangles_of_polygons(polygon, corners)
            assert found == pytest.approx(area)
            assert len(triangles) == len(polygon) - 2


def reading(reader: str, *parts: tuple[str, Facts], status: str = "read") -> Reading:
    return Reading(reader, Path("a.ply"), status, list(parts), "why" if status != "read" else "")


class TestVerdicts:
    @pytest.mark.parametrize(
        ("product", "others", "verdict"),
        [
            (BOX, (BOX, BOX), "agrees"),
            (BOX, (BOX, Facts(8, 10, 5, BOX.lower, BOX.upper)), "agrees with some"),
            (BOX, (Facts(8, 10, 5, BOX.lower, BOX.upper), None), "differs"),
            (BOX, (None, None), "only the product reads"),
            (None, (BOX, None), "only others read"),
            (None, (None, None), "nobody reads"),
        ],
    )
    def test_of_a_file(self, product: Facts | None, others: tuple[Facts | None, ...], verdict: str) -> None:
        found = [
            reading(name, ("", facts)) if facts else reading(name, status="refused")
            for name, facts in zip((PRODUCT, "trimesh", "meshio"), (product, *others), strict=True)
        ]
        (judged,) = judge(found)
        assert judged.verdict == verdict
        assert judged.message == ("" if product else "why")

    @pytest.mark.parametrize("status", ["failed", "time", "crash"])
    def test_failures(self, status: str) -> None:
        found = [reading(PRODUCT, status=status), reading("trimesh", ("", BOX))]
        assert [each.verdict for each in judge(found)] == ["fails"]

    def test_of_the_objects_of_a_file(self) -> None:
        found = [reading(PRODUCT, ("a", BOX), ("b", BOX)), reading(BLENDER, ("a", BOX), ("c", BOX))]
        assert [(each.part, each.verdict) for each in judge(found)] == [
            ("a", "agrees"),
            ("b", "only the product reads"),
            ("c", "only others read"),
        ]


def test_readers_of_a_format() -> None:
    assert readers_of(".pcd", blender=True) == [PRODUCT]
    assert readers_of(".obj", blender=False) == [PRODUCT, "trimesh", "meshio"]
    assert readers_of(".blend", blender=True) == [PRODUCT, BLENDER]
    assert readers_of(".blend", blender=False) == []


def test_commands_of_blender() -> None:
    assert find_blender("/opt/python3.11") == ("/opt/python3.11",)
    command = find_blender("/opt/blender")
    assert command is not None
    assert (command[0], command[-1]) == ("/opt/blender", "--python")


@pytest.mark.parametrize("suffix", [".gltf", ".glb"])
def test_gltf_without_its_animations(tmp_path: Path, suffix: str) -> None:
    models, folder = tmp_path / "my models", tmp_path / "copies"
    models.mkdir()
    folder.mkdir()
    tree, buffer = gltf_tree(uri="my%20box.bin")
    write(models, "my box.bin", buffer)
    still = write(models, f"still{suffix}", json.dumps(tree) if suffix == ".gltf" else FILES["box.glb"])
    assert without_animations(still, folder) == still
    animations: list[Any] = [{"channels": [], "samplers": []}]
    moving = (
        json.dumps(tree | {"animations": animations}) if suffix == ".gltf" else glb(animations=animations)
    )
    copy = without_animations(write(models, f"moving{suffix}", moving), folder)
    assert copy.parent == folder
    assert b"animations" not in copy.read_bytes()
    if suffix == ".glb":
        assert trimesh.load_scene(copy).area == pytest.approx(AREA)
    else:
        assert Path(unquote(json.loads(copy.read_bytes())["buffers"][0]["uri"])).read_bytes() == buffer
    assert without_animations(write(models, f"cut{suffix}", b"glTF{"), folder).parent == models


def test_folders_without_models(tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "nowhere"):
        with pytest.raises(BenchmarkError, match="folder"):
            find_models([folder])


def test_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("meshio")
    monkeypatch.delenv("BLENDER", raising=False)
    folder, output = tmp_path / "models", tmp_path / "out"
    folder.mkdir()
    for name in ("box.off", "box.glb"):
        write(folder, name, FILES[name])
    corners = ", ".join(map(str, QUADS[0]))
    write(folder, "cut.off", f"OFF\n8 2 0\n0 0 0\n1 0 0\n4 {corners}\n")
    write(folder, "huge.stl", bytes(80) + struct.pack("<I", 4_000_000_000))
    assert main(["files", str(folder), "--output", str(output), "--jobs", "1"]) == 0
    printed = capsys.readouterr().out
    assert "| off | 2 | 1 | 1 |" in printed
    with (output / "verdicts.csv").open() as file:
        verdicts = {row["file"]: row for row in csv.DictReader(file)}
    assert [verdicts[name]["verdict"] for name in ("box.off", "box.glb")] == ["agrees", "agrees"]
    assert verdicts["cut.off"]["verdict"] == "nobody reads"
    assert "'cut.off'" in verdicts["cut.off"]["message"]
    with (output / "readings.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["file"] == "box.off"]
    assert [(row["reader"], row["vertices"]) for row in rows] == [
        (reader, "8") for reader in (PRODUCT, "trimesh", "meshio")
    ]
    assert [float(row["area"]) for row in rows] == pytest.approx([AREA] * 3)
    assert "## Nobody reads" in (output / "summary.md").read_text()
