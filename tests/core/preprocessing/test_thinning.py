# SPDX-License-Identifier: MIT
"""Thinning of point clouds."""

from __future__ import annotations

import numpy as np
import pytest

from shapegoogle_core.preprocessing.thinning import thin


def test_thinning_evens_out_and_keeps_what_is_little() -> None:
    random = np.random.default_rng(0)
    points = random.random((20_000, 2)) ** [3, 1]  # crowded at one end
    points = np.column_stack([points, np.zeros(len(points))])
    thinned = thin(points, 1000)
    assert 800 < len(thinned) <= 1000
    half = (thinned[:, 0] < 0.5).mean()
    assert half == pytest.approx(0.5, abs=0.05)
    assert thin(points, len(points)) is points
