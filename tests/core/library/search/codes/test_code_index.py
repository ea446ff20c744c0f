# SPDX-License-Identifier: MIT
"""Codes in memory: what numpy, its stand-in for old versions and faiss find is the same."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapegoogle_core.library.search.codes import code_index
from shapegoogle_core.library.search.codes.code_index import CODE_TABLES, CodeIndex, WordTable, best_table
from shapegoogle_core.library.search.codes.hamming import count_bits_portable


@pytest.fixture(params=["numpy", "portable", "faiss"])
def table(request, monkeypatch):
    """Names of the tables; small blocks, so that a few codes fill several."""
    monkeypatch.setattr(code_index, "BLOCK", 16)
    monkeypatch.setitem(CODE_TABLES, "portable", lambda size: WordTable(size, count_bits_portable))
    if request.param == "faiss":
        pytest.importorskip("faiss")
    return request.param


class Expected:
    """Equation 19 read literally, on a list."""

    def __init__(self) -> None:
        self.codes: dict[int, np.ndarray] = {}

    def nearest(self, code: np.ndarray, count: int) -> list[int]:
        def distance(shape_id: int) -> int:
            return int(np.unpackbits(self.codes[shape_id] ^ code).sum())

        return sorted(sorted(self.codes), key=distance)[:count]


def check(table: str, seed: int, code_bytes: int, steps: list[tuple[int, int]], wanted: int) -> None:
    """Add and discard in turns, and compare after each step; few different bits, so that many are equal."""
    random = np.random.default_rng(seed)
    index, expected, last_id = CodeIndex(code_bytes, table), Expected(), 0
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


@settings(deadline=None, max_examples=60)
@given(
    seed=st.integers(0, 1_000_000),
    code_bytes=st.sampled_from([1, 2, 8, 9, 12, 16, 32, 33, 64]),
    steps=st.lists(st.tuples(st.integers(0, 40), st.integers(0, 5)), max_size=5),
    wanted=st.integers(1, 30),
)
@pytest.mark.parametrize("name", list(CODE_TABLES))
def test_nearest_equal_brute_force(name, seed, code_bytes, steps, wanted):
    if name == "faiss":
        pytest.importorskip("faiss")
    check(name, seed, code_bytes, steps, wanted)


def test_many_blocks_equal_brute_force(table):
    for seed in range(5):
        check(table, seed, 32, [(100, 3), (1, 0), (0, 1), (33, 2), (16, 0)], 20)


def test_tables_agree_on_many_codes_with_many_equals(table):
    random = np.random.default_rng(3)
    codes = random.integers(0, 4, (2_000, 8), np.uint8)
    reference, other = WordTable(8), CODE_TABLES[table](8)
    reference.add(codes)
    for portion in np.array_split(codes, [1, 7, 500, 1_501]):
        other.add(portion)
    for code in codes[:10]:
        for count in (1, 10, 300, 2_001):
            np.testing.assert_array_equal(other.nearest(code, count), reference.nearest(code, count))


def test_an_empty_index_has_nothing_near(table):
    assert CodeIndex(32, table).nearest(np.zeros(32, np.uint8), 10).tolist() == []
    assert CodeIndex(32, table).last_id == 0


def test_faiss_only_where_it_gains(monkeypatch):
    """Also not if it cannot be imported, or if it is a folder that happens to be called so."""
    named = SimpleNamespace(IndexBinaryFlat=object)
    for module, name in ((None, "numpy"), (SimpleNamespace(), "numpy"), (named, "faiss")):
        monkeypatch.setitem(sys.modules, "faiss", module)
        assert best_table(1_000) == "numpy"
        assert best_table(1_000_000) == name
