# SPDX-License-Identifier: MIT
"""Hamming search over binary codes, a million of them in milliseconds (algorithm 2 of the paper).

Codes are kept as columns of 64-bit words, so that each pass over the collection reads memory in order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "BLOCK",
    "BitCounter",
    "Words",
    "asymmetric_distances",
    "count_bits",
    "count_bits_portable",
    "hamming_distances",
    "nearest_by_distance",
    "nearest_codes",
    "nearest_in_blocks",
    "pack_words",
]

Words = NDArray[np.uint64]
BitCounter = Callable[[Words], NDArray[np.uint8]]

# Codes compared at once: half a megabyte for each word of the code, which stays in the cache of the
# processor.
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
    # Two arrays are used again and again: allocating one for each step takes as long as the steps.
    shifted: Words = words >> np.uint64(1)
    shifted &= _PAIRS
    counts: Words = words - shifted
    np.right_shift(counts, np.uint64(2), out=shifted)
    shifted &= _NIBBLES
    counts &= _NIBBLES
    counts += shifted
    np.right_shift(counts, np.uint64(4), out=shifted)
    counts += shifted
    counts &= _BYTES
    counts *= _ONES
    counts >>= np.uint64(56)
    totals: NDArray[np.uint8] = counts.astype(np.uint8)
    return totals


# numpy 2 uses the instruction of the processor, about three times as fast.
count_bits: BitCounter = getattr(np, "bitwise_count", count_bits_portable)


def pack_words(codes: NDArray[np.uint8]) -> Words:
    """Convert codes of bytes to columns of 64-bit words.

    Parameters
    ----------
    codes : (n, bytes) array of uint8
        Packed bits; the last word is filled up with zeros, the same in all codes.

    Returns
    -------
    words : (ceil(bytes / 8), n) array of uint64
        Row i holds word i of all codes.
    """
    count, code_bytes = codes.shape
    word_count = -(-code_bytes // 8)
    padded = np.zeros((count, 8 * word_count), np.uint8)
    padded[:, :code_bytes] = codes
    return np.ascontiguousarray(padded.view(np.uint64).T)


def hamming_distances(words: Words, query: Words, count: BitCounter = count_bits) -> NDArray[np.uint16]:
    """Compute the Hamming distance of one code to each of many (equation 19).

    Parameters
    ----------
    words : (w, n) array of uint64
        As `pack_words` returns them.
    query : (w,) array of uint64
        The code of the query.
    count : callable, optional
        Function that counts the set bits of an array of words.

    Returns
    -------
    distances : (n,) array of uint16
        Number of differing bits.
    """
    distances = np.zeros(words.shape[1], np.uint16)
    for row, word in zip(words, query, strict=True):
        distances += count(row ^ word)
    return distances


def asymmetric_distances(codes: NDArray[np.uint8], projection: NDArray[np.float32]) -> NDArray[np.float32]:
    """Compute asymmetric distances of codes from a query (Gordo et al. 2014).

    d = Σ |p_i| over the bits i in which the signs of the query's projections p differ from the code; with
    |p_i| = 1 it is the Hamming distance.

    Parameters
    ----------
    codes : (n, bytes) array of uint8
        Packed bits.
    projection : (s,) array
        p = A f + b of the query (equation 19), before taking signs.

    Returns
    -------
    distances : (n,) array of float32

    References
    ----------
    A. Gordo, F. Perronnin, Y. Gong, S. Lazebnik: Asymmetric Distances for Binary Embeddings. IEEE
    Transactions on Pattern Analysis and Machine Intelligence 36(1), 2014.
    """
    bits = np.unpackbits(codes, axis=1, count=len(projection)).astype(np.float32)
    # The sum of all positive p_i, minus Σ p_i over the bits that are set.
    return np.asarray(np.maximum(projection, 0).sum() - bits @ projection, np.float32)


def nearest_codes(
    words: Words, query: Words, count: int, counter: BitCounter = count_bits
) -> NDArray[np.intp]:
    """Find the codes nearest to a query, nearest first; among equals the one that comes first.

    Parameters
    ----------
    words : (w, n) array of uint64
        As `pack_words` returns them.
    query : (w,) array of uint64
        The code of the query.
    count : int
        Number of codes to find; fewer are returned if there are fewer.
    counter : callable, optional
        Function that counts the set bits of an array of words.

    Returns
    -------
    positions : (min(count, n),) array of int
    """
    blocks = (words[:, start : start + BLOCK] for start in range(0, words.shape[1], BLOCK))
    return nearest_in_blocks(blocks, query, count, counter)


def nearest_in_blocks(
    blocks: Iterable[Words], query: Words, count: int, counter: BitCounter = count_bits
) -> NDArray[np.intp]:
    """Find the codes nearest to a query in several arrays, with positions counted through all of them.

    Parameters
    ----------
    blocks : iterable of (w, n_i) array of uint64
        As `pack_words` returns them, ideally of `BLOCK` codes each.
    query, count, counter
        As for `nearest_codes`.

    Returns
    -------
    positions : (min(count, Σ n_i),) array of int
        As those of `nearest_codes`.
    """
    return nearest_by_distance((hamming_distances(block, query, counter) for block in blocks), count)


def nearest_by_distance(blocks: Iterable[NDArray[np.uint16]], count: int) -> NDArray[np.intp]:
    """Find the least of many distances that come in several arrays.

    Parameters
    ----------
    blocks : iterable of (n_i,) array of uint16
    count : int
        Number of distances to find; fewer are returned if there are fewer.

    Returns
    -------
    positions : (min(count, Σ n_i),) array of int
        Counted through all arrays; least first, among equals the one that comes first.
    """
    best = np.empty(0, np.intp)
    best_distances = np.empty(0, np.uint16)
    start = 0
    for distances in blocks:
        if len(best) == count:
            # A later code of the same distance stands behind. Few pass: of random codes the first block's
            # `count`, then half as many, a third as many, and so on.
            near = np.flatnonzero(distances < best_distances[-1]) if count else np.empty(0, np.intp)
        elif len(distances) > count:
            near = np.flatnonzero(distances <= np.partition(distances, count - 1)[count - 1])
        else:
            near = np.arange(len(distances))
        if len(near):
            best = np.concatenate([best, start + near])
            best_distances = np.concatenate([best_distances, distances[near]])
            order = np.argsort(best_distances, kind="stable")[:count]
            best, best_distances = best[order], best_distances[order]
        start += len(distances)
    return best
