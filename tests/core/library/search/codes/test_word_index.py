# SPDX-License-Identifier: MIT
"""The index of local words finds what a multiplication of all of them finds."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shapegoogle_core.library.search.codes.word_index import WordIndex

WORDS = 64


def expected(
    ids: NDArray[np.int64], codes: NDArray[np.uint8], weights: NDArray[np.float32], count: int
) -> list[list[int]]:
    scores = np.unpackbits(codes, axis=1).astype(np.float32) @ weights.T
    return [ids[np.lexsort((ids, -column))[:count]].tolist() for column in scores.T]


@pytest.fixture
def weights() -> NDArray[np.float32]:
    weights = np.random.default_rng(1).integers(0, 4, (3, WORDS)).astype(np.float32)
    weights[:, ::5] = 0  # words that the query has not
    return np.asarray(weights)


@pytest.mark.parametrize("portions", [[1], [3, 1, 13], [16], [15, 2, 40], [50, 7]])
@pytest.mark.parametrize("count", [1, 4, 100])
def test_the_heaviest_in_their_order(weights: NDArray[np.float32], portions: list[int], count: int) -> None:
    """In blocks of 16, filled in portions that end anywhere in a byte; small weights make many equals."""
    random = np.random.default_rng(len(portions))
    ids = np.cumsum(random.integers(1, 4, sum(portions)))
    codes = random.integers(0, 256, (len(ids), WORDS // 8), np.uint8)
    index = WordIndex(block=16)
    start = 0
    for portion in portions:
        index.add(ids[start : start + portion], codes[start : start + portion])
        start += portion
    assert index.last_id == ids[-1]
    found = [row.tolist() for row in index.nearest(weights, count)]
    assert found == expected(ids, codes, weights, count)
    among = ids[1::2]
    found = [row.tolist() for row in index.nearest(weights, count, among)]
    assert found == expected(among, codes[1::2], weights, count)
    index.discard(ids[::3].tolist())
    left = np.arange(len(ids)) % 3 > 0
    found = [row.tolist() for row in index.nearest(weights, count)]
    assert found == expected(ids[left], codes[left], weights, count)
    assert index.gone == len(ids) - left.sum()


def test_an_empty_one(weights: NDArray[np.float32]) -> None:
    index = WordIndex()
    assert index.last_id == 0
    assert [row.tolist() for row in index.nearest(weights, 5)] == [[], [], []]


def test_a_query_of_no_words() -> None:
    index = WordIndex()
    index.add(np.array([4, 7]), np.full((2, WORDS // 8), 255, np.uint8))
    assert index.nearest(np.zeros((1, WORDS), np.float32), 5)[0].tolist() == [4, 7]
