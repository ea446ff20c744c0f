# SPDX-License-Identifier: MIT
"""Equal rows of numbers."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from shapegoogle_core.mesh.places import first_at_place, hashed_rows, repeated_keys


@given(st.integers(0, 1_000), st.integers(1, 60))
def test_each_point_is_given_the_first_one_at_its_place(seed: int, count: int) -> None:
    points = np.random.default_rng(seed).choice([-0.5, 0.0, 0.5], (count, 3))
    first = [next(i for i in range(count) if (points[i] == point).all()) for point in points]
    assert first_at_place(points).tolist() == first


def test_minus_zero_is_zero() -> None:
    assert first_at_place(np.array([[0.0, 1, 2], [-0.0, 1, 2]])).tolist() == [0, 0]


def test_repeated_keys_are_all_found() -> None:
    keys = np.array([5, 3, 5, 2, 3, 9], np.uint64)
    assert repeated_keys(keys).tolist() == [0, 1, 2, 4]


def test_hashes_are_those_that_libraries_store() -> None:
    assert hashed_rows(np.array([[1, 2], [3, 4], [5, 6]], np.uint64)).tolist() == [
        3212035935212964563,
        17872229770495350552,
    ]
