# SPDX-License-Identifier: MIT
"""The nearest codes of views, in the best of several positions."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from shapegoogle_core.library.search.codes.view_index import ViewIndex


def by_hand(
    codes: np.ndarray, shape_ids: np.ndarray, alternatives: list[np.ndarray], count: int
) -> list[int]:
    """The same, bit by bit."""
    distances = [
        min(
            int(np.unpackbits(code[8 * half : 8 * half + 8] ^ other).sum())
            for half, others in enumerate(alternatives)
            for other in others
        )
        for code in codes
    ]
    return [int(shape_ids[i]) for i in np.argsort(distances, kind="stable")[:count]]


@given(
    seed=st.integers(0, 1000),
    shapes=st.integers(0, 60),
    count=st.integers(1, 70),
    removed=st.integers(0, 5),
    chosen=st.booleans(),
)
def test_it_finds_what_counting_finds(seed: int, shapes: int, count: int, removed: int, chosen: bool) -> None:
    random = np.random.default_rng(seed)
    codes = random.integers(0, 4, (shapes, 16)).astype(np.uint8)
    shape_ids = np.cumsum(random.integers(1, 4, shapes))
    alternatives = [random.integers(0, 4, (rows, 8)).astype(np.uint8) for rows in (1, 3)]
    index = ViewIndex(block=16)
    for part in np.array_split(np.arange(shapes), 3):
        index.add(shape_ids[part], codes[part])
    gone = set(random.permutation(shape_ids)[:removed].tolist())
    index.discard(gone)
    left = ~np.isin(shape_ids, list(gone))
    among = None
    if chosen:
        among = random.permutation(np.append(shape_ids[::2], 999))
        left &= np.isin(shape_ids, among)
    found = index.nearest(alternatives, count, among)
    assert found.tolist() == by_hand(codes[left], shape_ids[left], alternatives, count)
