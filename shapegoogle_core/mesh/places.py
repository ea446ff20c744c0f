# SPDX-License-Identifier: MIT
"""Places: equal rows of numbers, such as vertices with the same coordinates, found by 64-bit hashes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["first_at_place", "first_in_group", "hashed_rows", "repeated_keys"]


def hashed_rows(columns: NDArray[Any]) -> NDArray[np.uint64]:
    """Hash rows of 64-bit numbers: equal rows have equal hashes, others almost surely not.

    Parameters
    ----------
    columns : (d, n) array
        The rows, column by column.

    Returns
    -------
    hashed : (n,) array of uint64
        Libraries store sums of such hashes, so the function must not change.
    """
    bits = np.ascontiguousarray(columns).view(np.uint64)
    hashed = np.zeros(bits.shape[1], np.uint64)
    for column in bits:
        # The finaliser of splitmix64; unsigned arithmetic wraps on purpose.
        hashed += column
        hashed += np.uint64(0x9E3779B97F4A7C15)
        hashed *= np.uint64(0xBF58476D1CE4E5B9)
        hashed ^= hashed >> np.uint64(27)
        hashed *= np.uint64(0x94D049BB133111EB)
        hashed ^= hashed >> np.uint64(31)
    return hashed


def first_at_place(points: FloatArray) -> NDArray[np.int64]:
    """Find for each point the first one with the same coordinates.

    Parameters
    ----------
    points : (n, 3) array

    Returns
    -------
    first : (n,) array of int
    """
    everything = np.arange(len(points))
    keys = hashed_rows(points.T + 0.0)  # + 0.0: minus zero is zero
    candidates = repeated_keys(keys)
    if candidates.size == 0:
        return everything
    first = everything.copy()
    first[candidates] = candidates[first_in_group(keys[candidates])]
    same = (points[first] == points).all(axis=1)
    return np.where(same, first, everything)  # two places with one hash, if ever, stay apart


def repeated_keys(keys: NDArray[np.uint64]) -> NDArray[np.int64]:
    """Find all entries whose key is there more than once.

    Parameters
    ----------
    keys : (n,) array of uint64

    Returns
    -------
    repeated : (k,) array of int
        Ascending.
    """
    ordered = np.sort(keys)
    if (ordered[1:] != ordered[:-1]).all():  # mostly; sorting without indices is twice as fast
        return np.empty(0, np.int64)
    order = np.argsort(keys)
    same = keys[order[1:]] == keys[order[:-1]]
    repeated = np.zeros(len(keys), bool)
    repeated[order[1:][same]] = True
    repeated[order[:-1][same]] = True
    return np.flatnonzero(repeated)


def first_in_group(keys: NDArray[np.integer]) -> NDArray[np.int64]:
    """Find for each entry the index of the first entry with the same key.

    Parameters
    ----------
    keys : (n,) array of int

    Returns
    -------
    first : (n,) array of int
    """
    _, first, group = np.unique(keys, return_index=True, return_inverse=True)
    return np.asarray(first[group])
