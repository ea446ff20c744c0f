# SPDX-License-Identifier: MIT
"""The worker process."""

from __future__ import annotations

import importlib
from types import ModuleType

import pytest

from shapegoogle_core import ShapeGoogleError


def test_jobs_of_two(addon: ModuleType) -> None:
    """A worker that was stopped starts again, and an error comes back."""
    jobs = importlib.import_module(f"{addon.__name__}.jobs")
    worker = jobs.worker()
    assert worker.submit(abs, -3).result() == 3
    worker.stop()
    assert worker.submit(abs, -4).result() == 4
    with pytest.raises(ShapeGoogleError, match="because of a fault in Shape Google"):
        worker.submit(abs, "three").result()
