# SPDX-License-Identifier: MIT
"""Initial maps between two shapes, many of them, because a symmetric shape has several good maps.

They come from extremities whose distances are preserved, from the signs of the lowest eigenfunctions, and
from descriptors.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.correspondence.functional_maps import PointMaps, nearest
from shapegoogle_core.correspondence.working_surface import WorkingSurface
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["initial_maps"]

Indices = NDArray[np.int64]

# All lengths in this module are in units of √area.
# Largest difference of the distances of two pairs of tips, and the cost of a tip without counterpart.
_TIP_TOLERANCE, _UNMATCHED = 0.15, 0.1
_FEWEST_TIPS = 3
_BEAM, _TIP_MAPS = 200, 40
# Weight of descriptors relative to distances to tips, which reach 2 to 3.
_DESCRIPTOR_WEIGHT = 0.2
_SIGNED = 5  # lowest eigenfunctions of which all signs are tried
# Weight of eigenfunctions, which are about 1 on a surface of unit area, relative to descriptors.
_FUNCTION_WEIGHT = 0.5


def initial_maps(a: WorkingSurface, b: WorkingSurface) -> list[PointMaps]:
    """Make initial maps between the compared samples of two shapes.

    Parameters
    ----------
    a, b : WorkingSurface

    Returns
    -------
    maps : list of PointMaps
        Maps between the samples with known distances. Most of them are bad.
    """
    own = a.descriptors[a.compared]
    other = b.descriptors[b.compared]
    maps = [_both(own, other)]
    for pairs in tip_matchings(a, b):
        to_tips_a = a.apart[:, a.tips[pairs[:, 0]]]
        to_tips_b = b.apart[:, b.tips[pairs[:, 1]]]
        maps.append(
            _both(
                np.concatenate([to_tips_a, _DESCRIPTOR_WEIGHT * own], axis=1),
                np.concatenate([to_tips_b, _DESCRIPTOR_WEIGHT * other], axis=1),
            )
        )
    low_a, low_b = _lowest(a), _lowest(b)
    count = min(low_a.shape[1], low_b.shape[1])
    for signs in itertools.product((1.0, -1.0), repeat=count):
        maps.append(
            _both(
                np.concatenate([_FUNCTION_WEIGHT * low_a[:, :count] * signs, own], axis=1),
                np.concatenate([_FUNCTION_WEIGHT * low_b[:, :count], other], axis=1),
            )
        )
    return maps


def _lowest(surface: WorkingSurface) -> FloatArray:
    return surface.spectrum.eigenvectors[surface.compared, 1 : _SIGNED + 1]


def _both(own: FloatArray, other: FloatArray) -> PointMaps:
    return PointMaps(nearest(own, other), nearest(other, own))


def tip_matchings(a: WorkingSurface, b: WorkingSurface) -> list[Indices]:
    """Match extremities so that the distances between them are preserved, by a beam search.

    Parameters
    ----------
    a, b : WorkingSurface

    Returns
    -------
    matchings : list of (m, 2) arrays of int
        Positions in `a.tips` and `b.tips` of the pairs, m ≥ 3; the best matching first.
    """
    between_a = a.apart[np.ix_(a.tips, a.tips)]
    between_b = b.apart[np.ix_(b.tips, b.tips)]
    differences = _tip_descriptors(a)[:, None] - _tip_descriptors(b)[None]
    dissimilarity = np.sqrt((differences**2).sum(axis=2))
    # A state is its cost, and the counterparts of the tips of a so far, −1 for none.
    states: list[tuple[float, tuple[int, ...]]] = [(0.0, ())]
    for tip in range(len(a.tips)):
        grown = []
        for cost, chosen in states:
            matched = [(before, other) for before, other in enumerate(chosen) if other >= 0]
            grown.append((cost + _UNMATCHED, (*chosen, -1)))
            for other in range(len(b.tips)):
                if other in chosen:
                    continue
                apart = [abs(between_a[tip, x] - between_b[other, y]) for x, y in matched]
                if apart and max(apart) > _TIP_TOLERANCE:
                    continue
                mean = sum(apart) / len(apart) if apart else 0.0
                grown.append((cost + mean + 0.05 * float(dissimilarity[tip, other]), (*chosen, other)))
        states = sorted(grown)[:_BEAM]
    matchings = []
    for _, chosen in states:
        pairs = np.array([(tip, other) for tip, other in enumerate(chosen) if other >= 0]).reshape(-1, 2)
        if len(pairs) >= _FEWEST_TIPS:
            matchings.append(pairs)
    return matchings[:_TIP_MAPS]


def _tip_descriptors(surface: WorkingSurface) -> FloatArray:
    return surface.descriptors[surface.samples[surface.tips]]
