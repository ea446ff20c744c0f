# SPDX-License-Identifier: MIT
"""The scripts that measure speed measure what they say, at a size that takes seconds."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


@pytest.fixture
def script(monkeypatch):
    monkeypatch.syspath_prepend(str(SCRIPTS))
    return importlib.import_module


def test_search_against_size(script, tmp_path, monkeypatch):
    speed_search = script("speed_search")
    monkeypatch.setattr(speed_search, "RECALL_SIZES", (30,))
    monkeypatch.setattr(speed_search, "FULL_LIBRARY", 0)
    rows = speed_search.measure([30], 1, tmp_path)
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
    speed_search.plot(rows, tmp_path / "plot.svg")
    assert [entry.name for entry in tmp_path.iterdir()] == ["plot.svg"]


def test_meshes_to_index_are_read_back(script, tmp_path):
    from shapegoogle_core.mesh import read_mesh

    script("speed_indexing").write_meshes(tmp_path, 2, 2)
    first, second = (read_mesh(path) for path in sorted(tmp_path.iterdir()))
    assert first.vertices.shape == (162, 3)
    assert first.faces.shape == (320, 3)
    assert not np.array_equal(first.vertices, second.vertices)


@pytest.mark.skipif(sys.platform != "linux", reason="no /proc")
def test_figures_of_this_process(script):
    process_figures = script("process_figures")
    figures = process_figures.figures_of()
    assert 10 < figures.memory_mb <= figures.peak_mb < 100_000
    assert figures.threads >= 1
    assert figures.cpu_seconds > 0
    assert process_figures.figures_of(2**22 + 1) is None
    assert figures.parent in process_figures.descendants(figures.parent)


def test_from_a_file_to_a_signature(script, tmp_path):
    speed_describe = script("speed_describe")
    rows = speed_describe.measure([500], 1, tmp_path)
    assert [(row["format"], row["faces"]) for row in rows] == [(".ply", 996), (".obj", 996)]
    for row in rows:
        assert all(row["stages"][stage] > 0 for stage in speed_describe.STAGES)
        assert sum(row["stages"].values()) <= row["total"] + 1e-3
    speed_describe.plot(rows, tmp_path / "plot.svg")
    assert [entry.name for entry in tmp_path.iterdir()] == ["plot.svg"]
