# SPDX-License-Identifier: MIT
"""Leader clustering in near-linear time: groups of shapes within a distance of a leader (Hartigan 1975).

Shapes are taken one after the other. Each joins the nearest leader within the distance, or becomes a leader
itself. So every member is within the distance of its own leader, and a chain of small differences cannot join
a whole library into one group, as single linkage would. The order decides which shapes lead: the first ones.

A shape is compared only with leaders that share a key with it. A key is a sample of the code's bits; two
shapes at an angle θ differ in a share θ / π of their bits, so a key of k bits is equal with probability (1 -
θ/π)^k, and one of L keys with 1 - (1 - (1 - θ/π)^k)^L (Indyk and Motwani 1998, Charikar 2002).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Banding", "Clusters", "Distances", "Wrapper", "choose_banding", "cluster_by_leaders"]

# Share of the pairs at the very limit that at least one key should find; nearer pairs are missed less often.
RECALL = 0.99
MOST_KEYS = 96
# Codes unpacked to one byte for each bit at once: 64 MB for codes of 256 bits.
CODES_AT_ONCE = 250_000

Distances = Callable[[int, NDArray[np.int64]], FloatArray]
Wrapper = Callable[[Sequence[int]], Iterable[int]]


@dataclass(frozen=True)
class Banding:
    """Length and number of the keys of each shape.

    Attributes
    ----------
    key_bits : int
        k, bits in a key, at most 32.
    keys : int
        L, number of keys.
    """

    key_bits: int
    keys: int

    def recall(self, differing: float) -> float:
        """Compute the probability that two codes share a key.

        Parameters
        ----------
        differing : float
            Share of bits in which they differ, from 0 to 1; bits are taken as independent.

        Returns
        -------
        probability : float
        """
        return float(1 - (1 - (1 - differing) ** self.key_bits) ** self.keys)


@dataclass(frozen=True, eq=False)
class Clusters:
    """Leaders of shapes.

    Attributes
    ----------
    leader : (n,) array of int64
        Position of each shape's leader; a leader's own position.
    distance : (n,) array of float64
        To the leader; 0 for a leader.
    compared : int
        Number of pairs compared in full: the cost of the keys.
    """

    leader: NDArray[np.int64]
    distance: FloatArray
    compared: int

    def leaders(self) -> NDArray[np.int64]:
        """Return the positions of the leaders.

        Returns
        -------
        positions : (l,) array of int64
            In ascending order.
        """
        return np.flatnonzero(self.leader == np.arange(len(self.leader)))

    def groups(self) -> list[NDArray[np.int64]]:
        """List the leaders that have members, with these members.

        Returns
        -------
        groups : list of (g,) arrays of int64
            Positions: the leader first, then by distance.
        """
        order = np.lexsort((np.arange(len(self.leader)), self.distance, self.leader))
        # A leader has distance 0 and the lowest position, so it is the first of its group.
        starts = np.flatnonzero(np.diff(self.leader[order], prepend=-1))
        return [group for group in np.split(order, starts[1:]) if len(group) > 1]


def choose_banding(count: int, differing: float, code_bits: int) -> Banding:
    """Choose keys long enough to separate unlike shapes, and enough of them to find pairs at the limit.

    Parameters
    ----------
    count : int
        Number of shapes.
    differing : float
        Share of bits in which the codes of two shapes at the largest distance differ.
    code_bits : int
        Length of the code.

    Returns
    -------
    banding : Banding
        Its recall at `differing` is `RECALL`, or what `MOST_KEYS` keys give.
    """
    key_bits = min(max(int(np.ceil(np.log2(max(count, 2)))) + 4, 8), 32, code_bits)
    while True:
        equal = (1 - differing) ** key_bits
        keys = int(np.ceil(np.log1p(-RECALL) / np.log1p(-equal))) if equal < 1 else 1
        if keys <= MOST_KEYS or key_bits <= 8:
            return Banding(key_bits, min(keys, MOST_KEYS))
        key_bits -= 1


def cluster_by_leaders(
    codes: NDArray[np.uint8],
    distances: Distances,
    max_distance: float,
    banding: Banding,
    progress: Wrapper = iter,
) -> Clusters:
    """Group shapes around leaders.

    Parameters
    ----------
    codes : (n, s/8) array of uint8
        Binary codes, packed.
    distances : callable
        Given the position of a shape and those of others, (c,) array, returns its distances to them, (c,).
    max_distance : float
        Largest distance of a member from its leader.
    banding : Banding
    progress : callable, optional
        Wraps the loop over the shapes, as tqdm does.

    Returns
    -------
    clusters : Clusters

    Examples
    --------
    >>> points = np.array([0.0, 0.1, 5.0])
    >>> codes = np.zeros((3, 1), np.uint8)  # all share the only key, so every pair is compared
    >>> def distances(position, others):
    ...     return abs(points[others] - points[position])
    >>> cluster_by_leaders(codes, distances, 1.0, Banding(key_bits=8, keys=1)).groups()
    [array([0, 1])]
    """
    keys = _keys(codes, banding)
    leader = np.arange(len(codes))
    distance = np.zeros(len(codes))
    compared = 0
    tables: list[dict[int, list[int]]] = [defaultdict(list) for _ in range(banding.keys)]
    for position in progress(range(len(codes))):
        own = keys[:, position].tolist()
        candidates: set[int] = set()
        for table, key in zip(tables, own, strict=True):
            if key in table:
                candidates.update(table[key])
        if candidates:
            near = np.fromiter(candidates, np.int64, len(candidates))
            near.sort()  # equal distances: the first leader
            compared += len(near)
            away = distances(position, near)
            best = int(away.argmin())
            if away[best] <= max_distance:
                leader[position], distance[position] = near[best], away[best]
                continue
        for table, key in zip(tables, own, strict=True):
            table[key].append(position)
    return Clusters(leader, distance, compared)


def _keys(codes: NDArray[np.uint8], banding: Banding) -> NDArray[np.uint64]:
    """Return the (L, n) keys; the sampled bits are the same in every run."""
    random = np.random.default_rng(0)
    code_bits = 8 * codes.shape[1]
    samples = [random.choice(code_bits, banding.key_bits, replace=False) for _ in range(banding.keys)]
    powers = np.uint64(1) << np.arange(banding.key_bits, dtype=np.uint64)
    keys = np.empty((banding.keys, len(codes)), np.uint64)
    for start in range(0, len(codes), CODES_AT_ONCE):
        part = slice(start, start + CODES_AT_ONCE)
        bits = np.ascontiguousarray(np.unpackbits(codes[part], axis=1).T)
        for row, sample in enumerate(samples):
            # Bit by bit: the whole product would need eight bytes for each sampled bit.
            total = np.zeros(bits.shape[1], np.uint64)
            for power, bit in zip(powers, sample, strict=True):
                total |= bits[bit].astype(np.uint64) * power
            keys[row, part] = total
    return keys
