# SPDX-License-Identifier: MIT
from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from shapegoogle_core.library.packing import pack_bags, round_bags, unpack_bags

finite = st.floats(-(2.0**126), 2.0**126, width=32)
bags = arrays(np.float32, st.integers(1, 40), elements=finite)


@settings(deadline=None, max_examples=100)
@given(bags=bags, exponent=st.integers(-30, 0))
def test_rounding_keeps_eleven_bits_whatever_the_scale(bags, exponent):
    bags = np.ldexp(bags, exponent)
    largest = np.abs(bags).max().astype(np.float64)
    error = np.abs(round_bags(bags).astype(np.float64) - bags)
    smallest_float = float(np.finfo(np.float32).smallest_subnormal)
    assert (error <= np.maximum(2.0**-11 * np.abs(bags), 2.0**-39 * largest) + smallest_float).all()


@settings(deadline=None, max_examples=100)
@given(bags=bags)
def test_rounding_twice_changes_nothing_more(bags):
    once = round_bags(bags)
    np.testing.assert_array_equal(round_bags(once), once)


@settings(deadline=None, max_examples=50)
@given(
    bags=arrays(np.float32, st.integers(1, 20), elements=st.floats(-1, 1, width=32)),
    power=st.integers(-60, 60),
)
def test_a_bag_times_a_power_of_two_packs_alike(bags, power):
    assume_normal = np.where(np.abs(bags) < 1e-6, 0, bags).astype(np.float32)
    packed, exponent = pack_bags(assume_normal)
    scaled, scaled_exponent = pack_bags(np.ldexp(assume_normal, power))
    assert packed == scaled
    assert scaled_exponent == (exponent + power if assume_normal.any() else 0)


def test_an_empty_bag_stays_empty():
    packed, exponent = pack_bags(np.zeros(5, np.float32))
    assert (packed, exponent) == (bytes(10), 0)


def test_many_shapes_unpack_each_with_its_own_exponent():
    rows = [
        np.array([1.0, 0.5], np.float32),
        np.array([3e-30, 0.0], np.float32),
        np.array([7e30, 1e30], np.float32),
    ]
    packed = [pack_bags(row) for row in rows]
    halves = np.frombuffer(b"".join(content for content, _ in packed), "<f2").reshape(3, 2)
    unpacked = unpack_bags(halves, np.array([exponent for _, exponent in packed], np.int32))
    np.testing.assert_array_equal(unpacked, [round_bags(row) for row in rows])
    np.testing.assert_allclose(unpacked, rows, rtol=2.0**-11)
