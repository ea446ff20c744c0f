# SPDX-License-Identifier: MIT
"""Each section measures what it says, at a size that takes seconds."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.speed import describing, indexing, kinds, measuring, meshes, processes, reporting, search
from shapegoogle_core import Library
from shapegoogle_core.mesh import read_mesh


def test_search_against_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "RECALL_SIZES", (30,))
    monkeypatch.setattr(search, "FULL_LIBRARY", 0)
    rows = list(search.measure(measuring.Options((30,), 1, tmp_path)))
    assert {(row["bits"], row["top"]) for row in rows if row["part"] == "codes"} == {
        (128, 10),
        (128, 300),
        (256, 10),
        (256, 300),
    }
    (library,) = (row for row in rows if row["part"] == "library")
    assert library["bytes_per_shape"] > 30
    assert library["first_wall"] > 0
    for distance in ("Hamming", "asymmetric"):
        recall = [row["recall"] for row in rows if row["part"] == "recall" and row["distance"] == distance]
        assert recall == sorted(recall)
        assert 0.5 < recall[0] <= 1
    assert list(tmp_path.iterdir()) == []
    reporting.write_figure("search", search.draw(rows), tmp_path)
    assert (tmp_path / "speed-search.png").stat().st_size > 10_000


def test_meshes_to_index_are_read_back(tmp_path: Path) -> None:
    indexing.write_meshes(tmp_path, 2, 2)
    first, second = (read_mesh(path) for path in sorted(tmp_path.iterdir()))
    assert first.vertices.shape == (162, 3)
    assert first.faces.shape == (320, 3)
    assert not np.array_equal(first.vertices, second.vertices)


@pytest.mark.skipif(sys.platform != "linux", reason="no /proc")
def test_figures_of_this_process() -> None:
    figures = processes.figures_of()
    assert figures is not None
    assert 10 < figures.memory_mb <= figures.peak_mb < 100_000
    assert figures.threads >= 1
    assert figures.cpu_seconds > 0
    assert processes.figures_of(2**22 + 1) is None
    assert figures.parent in processes.descendants(figures.parent)


def test_curves_of_indexing_are_drawn(tmp_path: Path) -> None:
    curve = [{"seconds": 0.0, "storing_mb": 90.0, "worker_mb": 120.0}]
    rows = [
        {"part": "jobs", "size": 9, "ratio": 1.9, "ideal": 2.0, "shapes_per_second": {"1": 2.0, "2": 3.8}},
        {"part": "memory", "size": 90, "curve": curve},
    ]
    reporting.write_figure("indexing", indexing.draw(rows), tmp_path)
    assert (tmp_path / "speed-indexing.png").stat().st_size > 10_000


@pytest.mark.long
def test_from_a_file_to_a_signature(tmp_path: Path) -> None:
    rows = list(describing.measure(measuring.Options((500,), 1, tmp_path)))
    assert [(row["format"], row["faces"]) for row in rows] == [(".ply", 996), (".obj", 996)]
    for row in rows:
        assert all(row["stages"][stage] > 0 for stage in describing.STAGES)
        assert sum(row["stages"].values()) <= row["total"] + 1e-3
    assert list(tmp_path.iterdir()) == []
    reporting.write_figure("describing", describing.draw(rows), tmp_path)
    assert (tmp_path / "speed-describing.png").stat().st_size > 10_000


@pytest.mark.long
def test_searches_and_kinds_by_the_size_of_the_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kinds, "LIBRARY_VERTICES", 500)
    monkeypatch.setattr(kinds, "QUERY_VERTICES", 600)
    monkeypatch.setattr(kinds, "INDIVIDUALS", ("human",))
    for sizes in ((3,), (3, 5)):  # the second run copies the shapes of the first
        rows = list(kinds.measure(measuring.Options(sizes, 1, tmp_path, keep=tmp_path / "kept")))
    assert [row["shapes"] for row in rows] == 3 * [3] + 3 * [5]
    for row in rows:
        assert row["search_ratio"] == pytest.approx(row["search"] / row["describe"], abs=0.05)
    small, large = sorted((tmp_path / "kept").iterdir())
    with Library.open(small, read_only=True) as one, Library.open(large, read_only=True) as other:
        assert [shape.name for shape in other.shapes()][:3] == [shape.name for shape in one.shapes()]
    reporting.write_figure("kinds", kinds.draw(rows), tmp_path)


def test_a_creature_has_the_vertices_that_were_asked_for() -> None:
    assert len(meshes.creature(500).vertices) == 500
    assert len(meshes.creature(500, tolerance=0.02).vertices) == pytest.approx(500, rel=0.02)
