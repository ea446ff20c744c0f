# SPDX-License-Identifier: MIT
"""Spatial support: a fast test of which surfaces may have something in common with a query.

Most pairs of points that look alike are wrong, but right ones are compatible with each other, wrong ones with
few (see `aligning.motions`). Fewer pairs than for an alignment are enough to decide whether one is
worthwhile, if they have to agree more closely. docs/measurements/parts.md has the measurements behind the
constants.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.registration.aligning.motions import compatibility
from shapegoogle_core.registration.medial import ball_centers
from shapegoogle_core.registration.prepared_sample import PreparedSample
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["KEYPOINTS", "SUPPORTERS", "TOLERANCE", "supports"]

KEYPOINTS = 96
"""Number of the query's keypoints that are paired: with fewer, some halves are no longer found."""

TOLERANCE = 0.03
"""Largest difference of two distances of compatible pairs, in units of the candidate's √area.

Closer than in `align`, which helps most with halves that two shapes share.
"""

SUPPORTERS = 14
"""Number of pairs whose support of the leading pair counts."""


def supports(
    query: PreparedSample,
    candidates: Sequence[SurfaceSample],
    compared: NDArray[np.bool_],
    *,
    keypoints: int = KEYPOINTS,
    batch_size: int = 16,
) -> NDArray[np.float32]:
    """Measure the spatial support of candidates at each of the query's scales.

    Parameters
    ----------
    query : PreparedSample
    candidates : sequence of SurfaceSample
        All with the same number of keypoints.
    compared : (n, s) array of bool
        At which of the query's s scales each of the n candidates is compared.
    keypoints : int, optional
        Number of the query's keypoints that are paired.
    batch_size : int, optional
        Number of candidates compared together: few, so that their matrices stay in the processor's cache
        while all scales are compared.

    Returns
    -------
    supports : (n, s) array of float32
        From 0 to 1: for the pair that the others support most, the share of all pairs that are compatible
        with it and with one of its strongest supporters, averaged over these. 0 where it was not compared.
    """
    found = np.zeros(compared.shape, np.float32)
    rows = np.flatnonzero(compared.any(axis=1))
    # So many that on average `batch_size` are compared at each scale.
    at_once = max(batch_size, batch_size * found[rows].size // max(1, int(compared.sum())))
    for start in range(0, len(rows), at_once):
        some = rows[start : start + at_once]
        chosen = [candidates[row] for row in some.tolist()]
        descriptors = np.stack([candidate.descriptors for candidate in chosen])
        half_squares = np.einsum("bkd,bkd->bk", descriptors, descriptors) / 2
        few = slice(descriptors.shape[1])
        places, normals = (
            np.stack([getattr(one, name)[few] for one in chosen]) for name in ("points", "normals")
        )
        # Only of the keypoints: most candidates are looked at but once.
        radii = np.stack([one.radii[few] for one in chosen])
        points = places.astype(np.float32)
        centers = ball_centers(places, normals, radii).astype(np.float32)
        for scale in range(compared.shape[1]):
            asked = np.flatnonzero(compared[some, scale])
            if len(asked):
                part = slice(None) if len(asked) == len(some) else asked
                found[some[asked], scale] = _supports_at(
                    query,
                    scale,
                    keypoints,
                    descriptors[part],
                    half_squares[part],
                    points[part],
                    centers[part],
                )
    return found


def _supports_at(
    query: PreparedSample,
    scale: int,
    keypoints: int,
    descriptors: NDArray[np.float32],
    half_squares: NDArray[np.float32],
    points: NDArray[np.float32],
    centers: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Return the (b,) supports of b candidates with k keypoints each, given as arrays (b, k, ...)."""
    query_descriptors, distances, center_distances = (
        array[:keypoints] for array in query.at_scale(query.scales[scale])
    )
    likeness = query_descriptors @ descriptors.transpose(0, 2, 1)
    likeness -= half_squares[:, None]
    counterparts = likeness.argmax(axis=2)
    batch = np.arange(len(counterparts))[:, None]
    compatible = compatibility(
        counterparts,
        distances[:, :keypoints],
        center_distances[:, :keypoints],
        points[batch, counterparts],
        centers[batch, counterparts],
        TOLERANCE,
    )
    second_order = compatible * (compatible @ compatible)
    leaders = second_order.sum(axis=2).argmax(axis=1)[:, None, None]
    leading = np.take_along_axis(second_order, leaders, axis=1)[:, 0]
    supporters = min(SUPPORTERS, leading.shape[1])
    strongest = np.partition(leading, -supporters, axis=1)[:, -supporters:]
    return np.asarray(strongest.mean(axis=1) / len(query_descriptors))
