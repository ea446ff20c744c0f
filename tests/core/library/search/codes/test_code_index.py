# SPDX-License-Identifier: MIT
"""Codes in memory: the index finds the same as equation 19 read literally."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from shapegoogle_core.library.search.codes.code_index import CodeIndex
from shapegoogle_core.library.search.codes.hamming import BitCounter, count_bits, count_bits_portable

counters = pytest.mark.parametrize("counter", [count_bits, count_bits_portable], ids=["numpy", "portable"])


class Expected:
    """Equation 19 read literally, on a list."""

    def __init__(self) -> None:
        self.codes: dict[int, NDArray[np.uint8]] = {}

    def only(self, shape_ids: list[int]) -> Expected:
        chosen = Expected()
        chosen.codes = {shape_id: self.codes[shape_id] for shape_id in shape_ids if shape_id in self.codes}
        return chosen

    def nearest(self, code: NDArray[np.uint8], count: int) -> list[int]:
        def distance(shape_id: int) -> int:
            return int(np.unpackbits(self.codes[shape_id] ^ code).sum())

        return sorted(sorted(self.codes), key=distance)[:count]


def check(index: CodeIndex, seed: int, code_bytes: int, steps: list[tuple[int, int]], wanted: int) -> None:
    """Add and discard in turns, and compare after each step; few different bits, so that many are equal."""
    random = np.random.default_rng(seed)
    expected, last_id = Expected(), 0
    for added, removed in steps:
        shape_ids = last_id + np.cumsum(random.integers(1, 3, added), dtype=np.int64)
        codes = random.integers(0, 4, (added, code_bytes), np.uint8)
        index.add(shape_ids, codes)
        expected.codes.update(zip(shape_ids.tolist(), codes, strict=True))
        last_id = int(shape_ids[-1]) if added else last_id
        known = list(expected.codes)
        gone = random.choice(known, min(removed, len(known)), replace=False).tolist() if known else []
        index.discard(gone)
        for shape_id in gone:
            del expected.codes[shape_id]
        code = random.integers(0, 4, code_bytes, np.uint8)
        assert index.last_id == last_id
        assert index.nearest(code, wanted).tolist() == expected.nearest(code, wanted)
        among = np.flatnonzero(random.random(last_id + 3) < 0.4)
        chosen = expected.only(among.tolist())
        assert index.nearest(code, wanted, among).tolist() == chosen.nearest(code, wanted)


@settings(deadline=None, max_examples=60)
@given(
    seed=st.integers(0, 1_000_000),
    code_bytes=st.sampled_from([1, 2, 8, 9, 12, 16, 32, 33, 64]),
    steps=st.lists(st.tuples(st.integers(0, 40), st.integers(0, 5)), max_size=5),
    wanted=st.integers(1, 30),
)
@counters
def test_nearest_equal_brute_force(
    counter: BitCounter, seed: int, code_bytes: int, steps: list[tuple[int, int]], wanted: int
) -> None:
    check(CodeIndex(counter), seed, code_bytes, steps, wanted)


@counters
def test_many_blocks_equal_brute_force(counter: BitCounter) -> None:
    for seed in range(5):
        check(CodeIndex(counter, block=16), seed, 32, [(100, 3), (1, 0), (0, 1), (33, 2), (16, 0)], 20)


@counters
def test_portions_and_blocks_do_not_show_among_many_equals(counter: BitCounter) -> None:
    random = np.random.default_rng(3)
    codes = random.integers(0, 4, (2_000, 8), np.uint8)
    shape_ids = np.arange(1, 2_001)
    reference, other = CodeIndex(), CodeIndex(counter, block=16)
    reference.add(shape_ids, codes)
    for cut in np.split(np.arange(2_000), [1, 8, 508, 1_501]):
        other.add(shape_ids[cut], codes[cut])
    for code in codes[:10]:
        for count in (1, 10, 300, 2_001):
            np.testing.assert_array_equal(other.nearest(code, count), reference.nearest(code, count))


def test_an_empty_index_has_nothing_near() -> None:
    index = CodeIndex()
    code = np.zeros(32, np.uint8)
    assert index.nearest(code, 10).tolist() == index.nearest(code, 10, np.array([1])).tolist() == []
    assert index.last_id == 0
