# SPDX-License-Identifier: MIT
"""Hamming search over binary codes: how many bits differ, for a million codes in milliseconds (algorithm 2).

Codes are kept as columns of 64-bit words, so that each pass over the collection reads memory in order.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["count_bits", "count_bits_portable", "hamming_distances", "nearest_codes", "pack_words"]

Words = NDArray[np.uint64]
BitCounter = Callable[[Words], NDArray[np.uint8]]

# Codes compared at once: half a megabyte for each word of the code, which stays in the processor's cache.
BLOCK = 65_536

_PAIRS = np.uint64(0x5555555555555555)
_NIBBLES = np.uint64(0x3333333333333333)
_BYTES = np.uint64(0x0F0F0F0F0F0F0F0F)
_ONES = np.uint64(0x0101010101010101)


def count_bits_portable(words: Words) -> NDArray[np.uint8]:
    """Count the set bits of each word, for numpy before 2.0 (Blender 4.2 ships 1.24).

    Adds neighbouring bits, then pairs, then nibbles; a multiplication sums the eight bytes.

    Parameters
    ----------
    words : array of uint64

    Returns
    -------
    counts : array of uint8
        Of the same shape; 0 to 64.
    """
    counts: Words = words - ((words >> np.uint64(1)) & _PAIRS)
    counts = (counts & _NIBBLES) + ((counts >> np.uint64(2)) & _NIBBLES)
    counts = (counts + (counts >> np.uint64(4))) & _BYTES
    totals: NDArray[np.uint8] = ((counts * _ONES) >> np.uint64(56)).astype(np.uint8)
    return totals


# numpy 2 has the processor's own instruction for it, about three times as fast.
count_bits: BitCounter = getattr(np, "bitwise_count", count_bits_portable)


def pack_words(codes: NDArray[np.uint8]) -> Words:
    """Turn codes of bytes into columns of 64-bit words.

    Parameters
    ----------
    codes : (n, bytes) array of uint8
        Packed bits; the last word is filled up with zeros, which differ from no other zeros.

    Returns
    -------
    words : (ceil(bytes / 8), n) array of uint64
        Word i of all codes lies side by side in row i.
    """
    count, code_bytes = codes.shape
    word_count = -(-code_bytes // 8)
    padded = np.zeros((count, 8 * word_count), np.uint8)
    padded[:, :code_bytes] = codes
    return np.ascontiguousarray(padded.view(np.uint64).T)


def hamming_distances(words: Words, query: Words, count: BitCounter = count_bits) -> NDArray[np.uint32]:
    """Hamming distance of one code to each of many (equation 19).

    Parameters
    ----------
    words : (w, n) array of uint64
        As `pack_words` returns them.
    query : (w,) array of uint64
        The code that is looked for.
    count : callable, optional
        What counts the set bits of an array of words.

    Returns
    -------
    distances : (n,) array of uint32
        Number of differing bits.
    """
    distances = np.zeros(words.shape[1], np.uint32)
    for start in range(0, words.shape[1], BLOCK):
        block = slice(start, start + BLOCK)
        for row, word in zip(words, query, strict=True):
            distances[block] += count(row[block] ^ word)
    return distances


def nearest_codes(words: Words, query: Words, count: int) -> NDArray[np.intp]:
    """Positions of the codes nearest to a query, nearest first; among equals the one that comes first.

    Parameters
    ----------
    words : (w, n) array of uint64
        As `pack_words` returns them.
    query : (w,) array of uint64
        The code that is looked for.
    count : int
        How many are wanted; fewer come back when there are fewer codes.

    Returns
    -------
    positions : (min(count, n),) array of int
    """
    distances = hamming_distances(words, query)
    # Distances are small integers: counting how often each occurs finds the largest one still wanted in one
    # pass, and only the codes up to it have to be sorted.
    within = np.cumsum(np.bincount(distances))
    largest = np.searchsorted(within, count)
    positions = np.flatnonzero(distances <= largest)
    return positions[np.argsort(distances[positions], kind="stable")[:count]]
