# SPDX-License-Identifier: MIT
"""Work in slices: what is computed aside gives its result, or its error, to the steps that wait for it."""

from __future__ import annotations

import importlib
import threading
from types import ModuleType
from typing import Any

import pytest


@pytest.fixture
def slices(addon: ModuleType) -> Any:
    return importlib.import_module(f"{addon.__name__}.time_slices")


def test_steps_go_on_while_something_is_computed_aside(slices: Any) -> None:
    may_end = threading.Event()

    def compute() -> int:
        may_end.wait()
        return 7

    steps = slices.aside(compute)
    # Each step ends a slice, so that the window answers.
    assert slices.next_slice(steps)
    assert next(steps)
    may_end.set()
    assert slices.result_of(steps) == 7


def test_an_error_reaches_the_steps_that_wait(slices: Any) -> None:
    def fail() -> None:
        raise ValueError("no such shape")

    with pytest.raises(ValueError, match="no such shape"):
        slices.result_of(slices.aside(fail))
