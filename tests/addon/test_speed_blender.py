# SPDX-License-Identifier: MIT
"""The section that measures Blender measures the steps that people wait for, at a size that takes seconds."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import pytest

from benchmarks.speed import blender as speed_blender
from benchmarks.speed.measuring import Options


@pytest.mark.skipif(bool(bpy.app.binary_path), reason="the script measures the add-on of the repository")
def test_all_parts_are_measured(
    blender: Any, addon: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(speed_blender, "SHAPES", 3)
    monkeypatch.setattr(speed_blender, "LARGEST_CREATURE", 500)
    options = Options((2_000,), 1, tmp_path)
    start, find, paint = speed_blender.measure(options)
    assert start["blender"] == bpy.app.version_string
    assert 0 < start["cpu"] < 5_000
    for row, part in ((find, "find"), (paint, "paint")):
        assert row["part"] == part
        assert row["vertices"] == pytest.approx(2_000, rel=0.05)
        steps = [row[f"{step}_wall"] for step in ("read", "worker", "show")]
        assert min(steps) > 0
        assert sum(steps) == pytest.approx(row["waited_wall"], abs=0.5)
    assert find["shapes"] == 3
    assert find["describe_cpu"] > 0
    assert list(tmp_path.iterdir()) == []
    assert "sg_hks" in bpy.context.object.data.attributes
