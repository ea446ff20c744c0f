# SPDX-License-Identifier: MIT
"""Which of many surfaces may have something in common with a query, in an eighth of the time of a rough pose.

Of points that look alike most pairs are wrong. Right ones agree with each other on distances, wrong ones
with few. Half of the pairs that `align` compares are enough to tell where there is something to find, if they
have to agree closely.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.registration.alignment import PreparedSample, agreeing
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["supports"]

# Of the query, each with the one of the candidate's that looks most like it. With 64, halves of three of 31
# kinds of creatures had no more support by their whole than by anything; 128 take twice as long.
_KEYPOINTS = 96
# How well two of those pairs must agree, in units of the candidate's √area. Among creatures, 33 of each kind,
# 0.025 is a little better for parts of another mesh, 0.035 for swollen limbs and holes; 0.05, as in `align`,
# is worse for both, and much worse for halves that two shapes share.
_AGREEMENT = 0.03
# Support is what the leading pair has from so many of the others.
_SUPPORTERS = 14
# Candidates that are compared together: their matrices stay in the processor's cache.
_AT_ONCE = 16


def supports(
    query: PreparedSample, candidates: Sequence[SurfaceSample], asked: NDArray[np.bool_]
) -> NDArray[np.float32]:
    """Count how many correspondences agree with each other, at each of the query's scales.

    Parameters
    ----------
    query : PreparedSample
    candidates : sequence of SurfaceSample
        With the same number of keypoints each.
    asked : (n, s) array of bool
        At which of the query's s scales each of the n candidates is compared with it.

    Returns
    -------
    supports : (n, s) array of float32
        From 0 to 1. Of the correspondence that the others support most: which share of all agrees both with
        it and with one of its strongest supporters, on average. 0 where it was not asked.
    """
    found = np.zeros(asked.shape, np.float32)
    for start in range(0, len(candidates), _AT_ONCE):
        portion = slice(start, start + _AT_ONCE)
        prepared = [PreparedSample(sample) for sample in candidates[portion]]
        stacked = (
            np.stack([candidate.sample.descriptors for candidate in prepared]),
            np.stack([candidate.half_squares for candidate in prepared]),
            np.stack([candidate.key_points for candidate in prepared]),
            np.stack([candidate.key_centers for candidate in prepared]),
        )
        for scale in np.flatnonzero(asked[portion].any(axis=0)):
            rows = np.flatnonzero(asked[portion, scale])
            found[start + rows, scale] = _supports_at(query, int(scale), *(array[rows] for array in stacked))
    return found


def _supports_at(
    query: PreparedSample,
    scale: int,
    descriptors: NDArray[np.float32],
    half_squares: NDArray[np.float32],
    points: NDArray[np.float32],
    centers: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Supports of b candidates with k keypoints each: arrays (b, k, ...)."""
    looks, distances, center_distances = (array[:_KEYPOINTS] for array in query.looks[scale])
    there = (half_squares[:, None] - looks @ descriptors.transpose(0, 2, 1)).argmin(axis=2)
    agree = agreeing(
        there,
        distances[:, :_KEYPOINTS],
        center_distances[:, :_KEYPOINTS],
        np.take_along_axis(points, there[..., None], axis=1),
        np.take_along_axis(centers, there[..., None], axis=1),
        _AGREEMENT,
    )
    second_order = agree * (agree @ agree)
    leaders = second_order.sum(axis=2).argmax(axis=1)[:, None, None]
    leading = np.take_along_axis(second_order, leaders, axis=1)[:, 0]
    supporters = min(_SUPPORTERS, leading.shape[1])
    strongest = np.partition(leading, -supporters, axis=1)[:, -supporters:]
    return np.asarray(strongest.mean(axis=1) / len(looks))
