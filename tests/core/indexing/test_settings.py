# SPDX-License-Identifier: MIT
"""Settings of an indexing run."""

from __future__ import annotations

from dataclasses import replace

import pytest

from shapegoogle_core.cli import main
from shapegoogle_core.indexing import IndexSettings


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"jobs": 0}, "jobs must be at least 1, not 0"),
        ({"time_limit": 0.0}, "time_limit must be above 0 seconds"),
        ({"time_limit": float("nan")}, "time_limit must be above 0 seconds"),
        ({"memory_limit": 0}, "memory_limit must be at least 1 MB"),
    ],
)
def test_values_that_make_no_sense(changes: dict[str, float], fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        replace(IndexSettings(), **changes)  # type: ignore[arg-type]


def test_the_command_shows_the_defaults(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["index", "--help"])
    shown = " ".join(capsys.readouterr().out.split())
    assert f"describing one shape ({IndexSettings.time_limit:g})" in shown
    assert f"describing one shape ({IndexSettings.memory_limit})" in shown
