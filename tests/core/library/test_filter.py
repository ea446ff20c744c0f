# SPDX-License-Identifier: MIT
"""Conditions on the shapes that a search returns."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from shapegoogle_core import Filter


def test_a_filter_without_conditions_accepts_everything() -> None:
    assert Filter() == Filter(name=None, faces=None)
    assert not Filter().selects_shapes


@pytest.mark.parametrize(
    "condition",
    [
        {"name": "chair"},
        {"text": "chair"},
        {"area": (1, 2)},
        {"folder": "/models"},
        {"tag": "wood"},
        {"faces": (0, 10)},
        {"size": (None, 2.5)},
    ],
)
def test_conditions_on_stored_values_select_shapes(condition: dict[str, Any]) -> None:
    assert Filter(**condition).selects_shapes


@pytest.mark.parametrize("condition", [{"kind": "re-posed"}, {"min_similarity": 0.5}])
def test_conditions_on_results_do_not(condition: dict[str, Any]) -> None:
    assert not Filter(**condition).selects_shapes


def test_a_folder_may_be_a_path() -> None:
    assert Filter(folder=Path("models")) == Filter(folder="models")


@pytest.mark.parametrize(
    ("condition", "message"),
    [
        ({"name": ""}, "name must be a text that is not empty, not ''"),
        ({"folder": "  "}, "folder must be a text"),
        ({"tag": 7}, "tag must be a text that is not empty, not 7"),
        ({"faces": (10, 5)}, "faces must be a range from low to high, not 10 to 5"),
        ({"faces": (-1, 5)}, "faces must not be below 0, not -1"),
        ({"faces": 5}, r"faces must have a low and a high limit, such as \(1000, None\), not 5"),
        ({"faces": ("a", 2)}, "a limit of faces must be a number or None, not 'a'"),
        ({"folder": 5}, "folder must be a text that is not empty, not 5"),
        ({"min_similarity": "a"}, "min_similarity must be a number from 0 to 1, not 'a'"),
        ({"faces": (1, 2, 3)}, "faces must have a low and a high limit"),
        ({"size": (float("nan"), 1)}, "size must not be below 0, not nan"),
        ({"size": (1, float("nan"))}, "size must be a range from low to high, not 1 to nan"),
        ({"kind": "same"}, "there is no kind of evidence 'same'; choose one of identical, moved"),
        ({"min_similarity": 1.5}, "min_similarity must be a number from 0 to 1, not 1.5"),
        ({"min_similarity": float("nan")}, "min_similarity must be a number from 0 to 1"),
    ],
)
def test_conditions_that_nothing_meets_are_refused(condition: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Filter(**condition)
