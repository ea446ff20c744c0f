# SPDX-License-Identifier: MIT
"""Persistence of the maxima of a function on a graph."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray, IntArray

__all__ = ["persistent_maxima"]

Indices = NDArray[np.int64]


def persistent_maxima(values: FloatArray, edges: IntArray) -> tuple[Indices, FloatArray]:
    """Find the maxima of a function, and the height at which each merges with a higher one.

    0-dimensional persistence of superlevel sets (Edelsbrunner, Letscher, Zomorodian 2002; of the heat kernel:
    Skraba, Ovsjanikov, Chazal, Guibas 2010). While the water level sinks, each maximum appears as an island,
    born at its height; where two islands meet, the one with the lower maximum dies.

    Parameters
    ----------
    values : (n,) array
        Values of the function. Of equal values the one with the smaller index counts as higher.
    edges : (e, 2) array of int
        Pairs of neighbouring vertices.

    Returns
    -------
    maxima : (p,) array of int
        Vertices that are higher than all their neighbours, the highest first.
    deaths : (p,) array
        Value down to which each maximum persists. The highest maximum of a connected component dies at the
        lowest value of that component.
    """
    n = len(values)
    order = np.lexsort((np.arange(n), -values))
    rank = np.empty(n, np.int64)  # 0 is the highest; without ties from here on
    rank[order] = np.arange(n)
    start, end = rank[edges[:, 0]], rank[edges[:, 1]]
    uphill = np.arange(n)  # by rank: the highest among each vertex and its neighbours
    np.minimum.at(uphill, start, end)
    np.minimum.at(uphill, end, start)
    # A walk uphill stays on one island at any lower level, so that islands meet only on the edges between the
    # regions of two maxima.
    while not np.array_equal(uphill, uphill[uphill]):
        uphill = uphill[uphill]
    between = uphill[start] != uphill[end]
    saddle = np.maximum(start, end)[between]
    regions = np.stack([uphill[start], uphill[end]], axis=1)[between]
    sunk = saddle.argsort(kind="stable")

    maxima = np.flatnonzero(uphill == np.arange(n))
    parent = dict(zip(maxima.tolist(), maxima.tolist(), strict=True))
    death = {}

    def island(maximum: int) -> int:
        while parent[maximum] != maximum:
            parent[maximum] = parent[parent[maximum]]
            maximum = parent[maximum]
        return maximum

    for here, (one, other) in zip(saddle[sunk].tolist(), regions[sunk].tolist(), strict=True):
        older, younger = sorted((island(one), island(other)))
        if older != younger:
            parent[younger] = older
            death[younger] = here
    lowest = np.arange(n)
    part = np.array([island(maximum) for maximum in maxima.tolist()], np.int64)
    np.maximum.at(lowest, part[np.searchsorted(maxima, uphill)], np.arange(n))
    ends = [death.get(maximum, lowest[maximum]) for maximum in maxima.tolist()]
    return order[maxima], values[order[np.array(ends, np.int64)]]
