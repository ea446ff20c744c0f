# SPDX-License-Identifier: MIT
"""Hamming distances, against equation 19 read literally."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from shapegoogle_core.library.search.codes import hamming
from shapegoogle_core.library.search.codes.hamming import (
    BitCounter,
    Words,
    asymmetric_distances,
    count_bits,
    count_bits_portable,
    hamming_distances,
    nearest_codes,
    nearest_in_blocks,
    pack_words,
)

Codes = NDArray[np.uint8]

code_sets = st.tuples(st.integers(0, 40), st.integers(1, 33)).flatmap(lambda size: arrays(np.uint8, size))
counters = pytest.mark.parametrize("count", [count_bits, count_bits_portable], ids=["numpy", "portable"])


def brute_force(codes: Codes, query: Codes) -> NDArray[np.int64]:
    """Equation 19 read literally: unpack the bits and count where they differ."""
    return np.asarray((np.unpackbits(codes, axis=1) != np.unpackbits(query)).sum(axis=1))


@counters
@settings(deadline=None, max_examples=60)
@given(codes=code_sets, data=st.data())
def test_distances_equal_brute_force(count: BitCounter, codes: Codes, data: st.DataObject) -> None:
    query = data.draw(arrays(np.uint8, codes.shape[1]))
    distances = hamming_distances(pack_words(codes), pack_words(query[None])[:, 0], count)
    np.testing.assert_array_equal(distances, brute_force(codes, query))


@counters
def test_distances_over_several_blocks_equal_brute_force(
    count: BitCounter, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hamming, "BLOCK", 100)
    random = np.random.default_rng(0)
    codes, query = random.integers(0, 256, (1_037, 16), np.uint8), random.integers(0, 256, 16, np.uint8)
    distances = hamming_distances(pack_words(codes), pack_words(query[None])[:, 0], count)
    np.testing.assert_array_equal(distances, brute_force(codes, query))


def test_codes_longer_than_255_bits_do_not_overflow() -> None:
    codes = np.array([[0] * 64, [255] * 64], np.uint8)
    words = pack_words(codes)
    assert hamming_distances(words, words[:, 0]).tolist() == [0, 512]


@counters
@settings(deadline=None, max_examples=60)
@given(codes=code_sets, wanted=st.integers(1, 50), data=st.data())
def test_nearest_are_the_first_of_a_stable_sort(
    count: BitCounter, codes: Codes, wanted: int, data: st.DataObject
) -> None:
    query = data.draw(arrays(np.uint8, codes.shape[1]))
    positions = nearest_codes(pack_words(codes), pack_words(query[None])[:, 0], wanted, count)
    expected = np.argsort(brute_force(codes, query), kind="stable")[:wanted]
    np.testing.assert_array_equal(positions, expected)


@settings(deadline=None, max_examples=60)
@given(codes=code_sets, wanted=st.integers(1, 50), cuts=st.lists(st.integers(0, 40)), data=st.data())
def test_blocks_do_not_show(codes: Codes, wanted: int, cuts: list[int], data: st.DataObject) -> None:
    words = pack_words(codes)
    query = pack_words(data.draw(arrays(np.uint8, codes.shape[1]))[None])[:, 0]
    positions = nearest_in_blocks(np.split(words, sorted(cuts), axis=1), query, wanted)
    np.testing.assert_array_equal(positions, nearest_codes(words, query, wanted))


@settings(deadline=None, max_examples=60)
@given(words=arrays(np.uint64, st.integers(0, 30)))
def test_portable_count_is_that_of_python(words: Words) -> None:
    assert count_bits_portable(words).tolist() == [int(word).bit_count() for word in words]


@given(codes=code_sets, data=st.data())
def test_asymmetric_distances_weigh_the_bits_that_differ(codes: Codes, data: st.DataObject) -> None:
    """With projections of one size they are Hamming distances; in general sums over the bits that differ."""
    bits = 8 * codes.shape[1]
    signs = data.draw(arrays(np.bool_, bits))
    even = np.where(signs, 1.0, -1.0).astype(np.float32)
    np.testing.assert_allclose(
        asymmetric_distances(codes, even), brute_force(codes, np.packbits(signs)), atol=1e-3
    )
    sizes = data.draw(arrays(np.float32, bits, elements=st.floats(0.125, 8, width=32)))
    expected = ((np.unpackbits(codes, axis=1).astype(bool) != signs) * sizes).sum(axis=1)
    np.testing.assert_allclose(asymmetric_distances(codes, even * sizes), expected, atol=1e-2)
