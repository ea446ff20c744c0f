# SPDX-License-Identifier: MIT
"""Bags in half the room: 16-bit floats with one exponent for each shape.

A library stores the bags of a shape as IEEE half floats after multiplying them by the power of two that
brings the largest entry into [2¹⁴, 2¹⁵), so nothing overflows or vanishes whatever the scale. An entry keeps
11 significant bits down to 2⁻²⁸ of the largest. Rounding twice changes nothing more, so a query that is
rounded the same way has exactly the bags of its copy in the library.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["pack_bags", "round_bags", "unpack_bags"]

# frexp gives a mantissa in [0.5, 1): times 2¹⁵ it is the largest binade that rounds without overflow.
_TARGET_EXPONENT = 15
# 2⁻¹⁴⁹ is the smallest positive float32: the factor that brings a bag back must not vanish itself.
_SMALLEST_EXPONENT = -149


def pack_bags(bags: NDArray[np.float32]) -> tuple[bytes, int]:
    """Round the bags of one shape to half floats.

    Parameters
    ----------
    bags : (B,) array of float32
        Finite.

    Returns
    -------
    packed : bytes
        2·B bytes, little-endian.
    exponent : int
        Multiply the half floats by 2**exponent to have the bags back.
    """
    largest = float(np.max(np.abs(bags), initial=0.0))
    exponent = max(int(np.frexp(largest)[1]) - _TARGET_EXPONENT, _SMALLEST_EXPONENT) if largest > 0.0 else 0
    return np.ldexp(bags, -exponent).astype("<f2").tobytes(), exponent


def unpack_bags(halves: NDArray[np.float16], exponents: NDArray[np.int32]) -> NDArray[np.float32]:
    """Bring stored bags back.

    Parameters
    ----------
    halves : (n, B) array of float16
    exponents : (n,) array of int32

    Returns
    -------
    bags : (n, B) array of float32
    """
    factors = np.ldexp(np.float32(1.0), exponents)
    bags: NDArray[np.float32] = halves.astype(np.float32) * factors[:, None]
    return bags


def round_bags(bags: NDArray[np.float32]) -> NDArray[np.float32]:
    """Bags as they would come back from a library.

    Parameters
    ----------
    bags : (B,) array of float32
        Finite.

    Returns
    -------
    rounded : (B,) array of float32
    """
    packed, exponent = pack_bags(bags)
    halves = np.frombuffer(packed, "<f2")
    rounded: NDArray[np.float32] = unpack_bags(halves[None], np.array([exponent], np.int32))[0]
    return rounded
