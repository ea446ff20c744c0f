# SPDX-License-Identifier: MIT
"""Shared checks of arguments."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from shapegoogle_core.api.arguments import as_path, as_paths, as_tuple, check_count, check_number


def test_counts_are_whole_numbers() -> None:
    for right in (1, 7, np.int64(3)):
        check_count("k", right)
    for wrong in (0, -1, 1.5, "3", None, True, math.nan):
        with pytest.raises(ValueError, match="k must be a whole number of at least 1, not"):
            check_count("k", wrong)


def test_numbers_have_limits() -> None:
    for right in (0, 0.5, 1, np.float32(0.1)):
        check_number("share", right, most=1)
    for wrong in (-0.1, 1.1, math.nan, math.inf, "a", None):
        with pytest.raises(ValueError, match="share must be a number from 0 to 1, not"):
            check_number("share", wrong, most=1)
    with pytest.raises(ValueError, match="time must be a number ≥ 0, not inf"):
        check_number("time", math.inf)
    with pytest.raises(ValueError, match="sigma must be a positive number, not 0"):
        check_number("sigma", 0, positive=True)


def test_paths_are_expanded_and_one_is_a_list() -> None:
    assert as_path("~/a") == Path.home() / "a"
    assert as_paths("ab") == as_paths(Path("ab")) == as_paths(["ab"]) == [Path("ab")]
    for wrong in (None, 3, [3]):
        with pytest.raises(ValueError, match=r"must be a str or a pathlib\.Path, not"):
            as_paths(wrong)  # type: ignore[arg-type]


def test_one_value_is_a_tuple_of_one() -> None:
    assert as_tuple("tags", "wood", str, "a text") == ("wood",)
    assert as_tuple("tags", ["wood", "old"], str, "a text") == ("wood", "old")
    assert as_tuple("tags", (), str, "a text") == ()
    for wrong in (5, [5], None, b"w"):
        with pytest.raises(ValueError, match="tags must be a text, not "):
            as_tuple("tags", wrong, str, "a text")
