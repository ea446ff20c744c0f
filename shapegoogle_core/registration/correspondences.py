# SPDX-License-Identifier: MIT
"""Pairs of points that look alike, and the motions on which groups of pairs agree.

Most pairs of points that look alike are wrong, but the right ones preserve distances, so they are compatible
with each other. Groups of pairs that many other compatible pairs support (second-order spatial compatibility,
SC²-PCR, Chen et al. 2022) give candidates of the motion.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.frames import similarity_transformations
from shapegoogle_core.registration.prepared_sample import PreparedSample, point_distances

__all__ = ["compatibility", "correspondences", "motions"]

# Largest difference of two distances of compatible pairs, in units of √area.
_TOLERANCE = 0.05
_GROUPS, _GROUP_SIZE = 12, 16


def correspondences(
    query: PreparedSample, candidate: PreparedSample, scale: int
) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """Pair each keypoint of the query with the most similar one of the candidate, and score the pairs.

    Parameters
    ----------
    query, candidate : PreparedSample
    scale : int
        Index of one of the query's scales.

    Returns
    -------
    counterparts : (k,) array of int
        Keypoints of the candidate.
    second_order : (k, k) array of float32
        Number of pairs that are compatible with both of two compatible pairs; 0 for incompatible pairs.
    """
    descriptors, distances, center_distances = query.at_scales[scale]
    counterparts = (candidate.half_squares - descriptors @ candidate.sample.descriptors.T).argmin(axis=1)
    first_order = compatibility(
        counterparts,
        distances,
        center_distances,
        candidate.key_points[counterparts],
        candidate.key_centers[counterparts],
        _TOLERANCE,
    )
    return counterparts, first_order * (first_order @ first_order)


def compatibility(
    counterparts: NDArray[np.intp],
    distances: NDArray[np.float32],
    center_distances: NDArray[np.float32],
    points: NDArray[np.float32],
    centers: NDArray[np.float32],
    tolerance: float,
) -> NDArray[np.float32]:
    """Find out which pairs preserve each other's distances, both of the points and of their ball centres.

    Parameters
    ----------
    counterparts : (..., k) array of int
        Counterpart of each of k keypoints of a query.
    distances, center_distances : (k, k) arrays
        Distances between those keypoints, and between the centres of their medial balls.
    points, centers : (..., k, 3) arrays
        Positions of the counterparts, and of the centres of their medial balls.
    tolerance : float
        Largest difference of two distances.

    Returns
    -------
    compatible : (..., k, k) array of float32
        1 for compatible pairs, else 0.
    """
    compatible = np.abs(distances - point_distances(points)) < tolerance
    compatible &= np.abs(center_distances - point_distances(centers)) < tolerance
    # Two keypoints with the same counterpart contradict each other.
    compatible &= counterparts[..., :, None] != counterparts[..., None, :]
    return np.asarray(compatible, np.float32)


def motions(
    query: PreparedSample,
    candidate: PreparedSample,
    counterparts: NDArray[np.intp],
    second_order: NDArray[np.float32],
    groups: int = _GROUPS,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Fit a motion to each group of pairs that support each other.

    Parameters
    ----------
    query, candidate : PreparedSample
    counterparts, second_order : (k,) array of int, (k, k) array of float32
        From `correspondences`.
    groups : int, optional
        Maximum number g of groups.

    Returns
    -------
    scales, rotations, translations : (g,), (g, 3, 3) and (g, 3) arrays
    """
    members = _groups(second_order, groups)
    weights = np.maximum(np.take_along_axis(second_order[members[:, -1]], members, axis=1), 1e-3)
    weights[:, -1] = weights.max(axis=1)
    there = counterparts[members]
    return similarity_transformations(
        np.concatenate([query.points[members], query.centers[members]], axis=1),
        np.concatenate([candidate.points[there], candidate.centers[there]], axis=1),
        np.tile(weights.astype(np.float64), 2),
    )


def _groups(second_order: NDArray[np.float32], count: int) -> NDArray[np.int64]:
    """Return (g, m) pairs that many others support, each as the last one of a group of its supporters."""
    size = min(_GROUP_SIZE, len(second_order) - 1)
    taken = np.zeros(len(second_order), bool)
    groups = []
    for leader in np.argsort(-second_order.sum(axis=1)):
        if taken[leader]:
            continue
        members = np.argpartition(-second_order[leader], size)[:size]
        taken[members] = True
        groups.append(np.append(members, leader))
        if len(groups) == count:
            break
    return np.array(groups)
