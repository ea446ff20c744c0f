# SPDX-License-Identifier: MIT
"""Grids in which points are merged."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from shapegoogle_core.preprocessing.grid import cell_numbers, finest_cell


@given(st.integers(0, 2**32 - 1), st.floats(1e-3, 10))
def test_points_have_one_number_exactly_if_they_share_a_cell(seed: int, cell: float) -> None:
    position = np.random.default_rng(seed).random((100, 3))
    numbers = cell_numbers(position, cell)
    cells = np.floor(position / cell)
    assert np.array_equal(numbers[:, None] == numbers, (cells[:, None] == cells).all(axis=2))


@given(st.integers(0, 2**32 - 1), st.integers(1, 100))
def test_the_finest_cell_keeps_the_budget(seed: int, budget: int) -> None:
    position = np.random.default_rng(seed).random((100, 3))

    def count_at(cell: float) -> int:
        return len(np.unique(cell_numbers(position, cell)))

    cell = finest_cell(float(position.max()), count_at, budget, 16)
    assert count_at(cell) <= budget
    too_small = (cell - 2 * float(position.max()) / 2**16) * (1 - 1e-12)
    assert budget == 100 or count_at(too_small) > budget
