# SPDX-License-Identifier: MIT
"""The summary of measured keypoints, and the measurement itself on one creature."""

from __future__ import annotations

import argparse
import math
from typing import Any

import pytest

from benchmarks.experiments import keypoints


def row(detector: str, kind: str, strength: int, repeated: float, points: int = 4) -> dict[str, Any]:
    found = {"points": points, "repeated": repeated, "chance": 0.1}
    return {"detector": detector, "class": kind, "strength": strength, **found}


@pytest.fixture
def rows() -> list[dict[str, Any]]:
    return [
        row("one", "noise", 1, 1.0),
        row("one", "noise", 3, 0.5),
        row("one", "holes", 1, 0.75),
        row("two", "noise", 1, 0.25),
        row("two", "noise", 1, math.nan, points=0),
    ]


def test_means_over_shapes_and_strengths(rows: list[dict[str, Any]]) -> None:
    figures = {
        (figure["detector"], figure["class"], figure["strength"]): figure
        for figure in keypoints.summary(rows)
    }
    assert figures["one", "noise", 1]["repeated"] == 1
    assert figures["one", "noise", "all"]["repeated"] == 0.75
    assert figures["one", "average", "all"]["repeated"] == 0.75
    # Who finds no point has no share, but is counted.
    assert figures["two", "average", "all"]["repeated"] == 0.25
    assert figures["two", "average", "all"]["points"] == 2
    assert figures["two", "average", "all"]["without_points"] == 1


def test_table_shows_what_there_is(rows: list[dict[str, Any]]) -> None:
    lines = keypoints.table(keypoints.summary(rows)).splitlines()
    (noise,) = [line for line in lines if line.startswith("noise")]
    assert noise.split() == ["noise", "|", "100", "50", "75", "|", "25", "–", "25"]
    assert lines[-1].split() == ["chance", "|", "10.0", "|", "10.0"]


def test_a_creature_is_measured_in_all_ways(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("skimage")
    monkeypatch.setattr(keypoints, "VERTICES", 1000)
    options = argparse.Namespace(strengths=(1,), preparation="preprocessed")
    rows = keypoints.measure(options, keypoints.Null("fish", 100))
    assert {(row["class"], row["strength"]) for row in rows} >= {
        ("isometry", 1),
        ("noise", 1),
        ("partial", 1),
    }
    assert all(0 <= row["chance"] <= 1 for row in rows)
    scaled = [row for row in rows if row["class"] == "scale" and row["points"]]
    assert scaled
    assert all(row["repeated"] == 1 for row in scaled)
