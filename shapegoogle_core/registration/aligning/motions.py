# SPDX-License-Identifier: MIT
"""Candidates of the motion of a query onto many others: from pairs of points, and from principal axes.

Most pairs of points that look alike are wrong, but the right ones preserve distances, so they are compatible
with each other. Groups of pairs that many other compatible pairs support (second-order spatial compatibility,
SC²-PCR, Chen et al. 2022) give candidates of the motion. The principal axes of the medial axis give others.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.aligning.sample_stack import SampleStack
from shapegoogle_core.registration.frames import Frame, similarity_transformations
from shapegoogle_core.registration.point_distances import point_distances
from shapegoogle_core.registration.prepared_sample import PreparedSample

__all__ = ["Motions", "axis_motions", "compatibility", "joined", "paired_motions", "reverse_motions"]

# Largest difference of two distances of compatible pairs, in units of √area.
_TOLERANCE = 0.05
_GROUP_SIZE = 16
# True scale by that at which two axes have the same size: a swollen limb is a little longer too.
_SIZE_RATIO = 0.93
# Candidates compared at once: few, so that their matrices stay in the processor's cache.
_AT_ONCE = 16
# Proper rotations that take the coordinate axes to each other.
_SIGNED = [
    np.diag(signs).astype(float)[list(order)]
    for order in permutations(range(3))
    for signs in product((1, -1), repeat=3)
]
_AXIS_ROTATIONS = np.array([matrix for matrix in _SIGNED if np.linalg.det(matrix) > 0])


_Places = tuple[NDArray[np.float32], NDArray[np.float32]]


@dataclass(frozen=True, eq=False)
class Motions:
    """Similarity transformations of a query onto some of many candidates.

    Attributes
    ----------
    rows : (h,) array of int
        Which candidate each of h motions belongs to.
    scales, rotations, translations : (h,), (h, 3, 3) and (h, 3) arrays
        x ↦ s R x + t, from the units of the query to those of the candidate.
    """

    rows: NDArray[np.intp]
    scales: FloatArray
    rotations: FloatArray
    translations: FloatArray

    def __getitem__(self, chosen: NDArray[np.intp] | NDArray[np.bool_]) -> Motions:
        """Choose some of the motions."""
        return Motions(
            self.rows[chosen], self.scales[chosen], self.rotations[chosen], self.translations[chosen]
        )

    def __len__(self) -> int:
        return len(self.rows)

    def frame(self, position: int) -> Frame:
        """Return one of the motions."""
        return Frame(float(self.scales[position]), self.rotations[position], self.translations[position])

    def within(self, smallest: float, largest: float) -> Motions:
        """Return those whose scale is between two bounds."""
        return self[(self.scales > smallest) & (self.scales < largest)]


def joined(motions: list[Motions]) -> Motions:
    """Join lists of motions, those of each candidate together and in their order.

    Parameters
    ----------
    motions : list of Motions
        At least one.

    Returns
    -------
    motions : Motions
    """
    names = ("rows", "scales", "rotations", "translations")
    everything = Motions(*(np.concatenate([getattr(some, name) for some in motions]) for name in names))
    return everything[np.argsort(everything.rows, kind="stable")]


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
    distances, center_distances : (..., k, k) arrays
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
    differences = point_distances(points)
    differences -= distances
    compatible = np.abs(differences, out=differences) < tolerance
    differences = point_distances(centers)
    differences -= center_distances
    compatible &= np.abs(differences, out=differences) < tolerance
    # Two keypoints with the same counterpart contradict each other.
    compatible &= counterparts[..., :, None] != counterparts[..., None, :]
    return np.asarray(compatible, np.float32)


def paired_motions(
    query: PreparedSample,
    candidates: SampleStack,
    rows: NDArray[np.intp],
    scale: float,
    groups: int,
    keypoints: int | None = None,
) -> Motions:
    """Fit a motion to each group of pairs of keypoints that support each other.

    Parameters
    ----------
    query : PreparedSample
    candidates : SampleStack
    rows : (b,) array of int
        The candidates to pair.
    scale : float
        Size at which the query is compared.
    groups : int
        Number of motions for each candidate.
    keypoints : int, optional
        Number of the query's keypoints that are paired; by default all that may be.

    Returns
    -------
    motions : Motions
    """
    found = [
        _paired(query, candidates, rows[start : start + _AT_ONCE], scale, groups, keypoints)
        for start in range(0, len(rows), _AT_ONCE)
    ]
    return joined(found)


def _paired(
    query: PreparedSample,
    candidates: SampleStack,
    rows: NDArray[np.intp],
    scale: float,
    groups: int,
    keypoints: int | None,
) -> Motions:
    descriptors, distances, center_distances = (array[:keypoints] for array in query.at_scale(scale))
    distances, center_distances = distances[:, :keypoints], center_distances[:, :keypoints]
    likeness = descriptors @ candidates.descriptors[rows].transpose(0, 2, 1)
    likeness -= candidates.half_squares[rows, None]
    counterparts = likeness.argmax(axis=2)
    points = candidates.points[rows[:, None], counterparts]
    centers = candidates.centers[rows[:, None], counterparts]
    compatible = compatibility(counterparts, distances, center_distances, points, centers, _TOLERANCE)
    known = len(distances)
    own = (
        np.broadcast_to(query.key_points[:known], points.shape),
        np.broadcast_to(query.key_centers[:known], points.shape),
    )
    return _grouped(rows, compatible, own, (points, centers), groups)


def reverse_motions(
    query: PreparedSample,
    candidates: SampleStack,
    rows: NDArray[np.intp],
    scale: float,
    groups: int,
    keypoints: int,
) -> Motions:
    """Fit motions to pairs of keypoints, for candidates that are parts of the query.

    Each keypoint of a candidate is paired with one of the query: all of a part have counterparts on its
    whole, but not the other way round.

    Parameters
    ----------
    query : PreparedSample
    candidates : SampleStack
    rows : (b,) array of int
        The candidates to pair.
    scale : float
        Size at which the candidates are compared.
    groups : int
        Number of motions for each candidate.
    keypoints : int
        Number of a candidate's keypoints that are paired.

    Returns
    -------
    motions : Motions
        From the query to the candidates, as from `paired_motions`.
    """
    # Instead of shrinking each candidate, the query is enlarged once.
    growth = np.float32(1 / scale)
    descriptors, half_squares = query.enlarged(1 / scale)
    count = min(keypoints, candidates.descriptors.shape[1])
    found = []
    for start in range(0, len(rows), _AT_ONCE):
        some = rows[start : start + _AT_ONCE]
        own = candidates.points[some, :count], candidates.centers[some, :count]
        likeness = candidates.descriptors[some, :count] @ descriptors.T
        likeness -= half_squares
        counterparts = likeness.argmax(axis=2)
        points, centers = (
            places.take(counterparts, axis=0) for places in (query.key_points, query.key_centers)
        )
        distances, center_distances = (array[some, :count, :count] for array in candidates.distances)
        compatible = compatibility(
            counterparts, distances, center_distances, growth * points, growth * centers, _TOLERANCE
        )
        found.append(_grouped(some, compatible, (points, centers), own, groups))
    return joined(found)


def _grouped(
    rows: NDArray[np.intp], compatible: NDArray[np.float32], first: _Places, second: _Places, groups: int
) -> Motions:
    """Fit motions that take (b, k, 3) points and centres of the query to those of b candidates."""
    members, weights = _groups(compatible * (compatible @ compatible), groups)
    batch = np.arange(len(rows))[:, None, None]
    size = len(rows) * members.shape[1]
    own, others = (
        np.concatenate([points[batch, members], centers[batch, members]], axis=2)
        .reshape(size, -1, 3)
        .astype(np.float64)
        for points, centers in (first, second)
    )
    fitted = similarity_transformations(own, others, np.tile(weights, 2).reshape(size, -1))
    return Motions(np.repeat(rows, members.shape[1]), *fitted)


def _groups(second_order: NDArray[np.float32], count: int) -> tuple[NDArray[np.intp], FloatArray]:
    """Return (b, g, n) pairs that many others support, each with its supporters, and their weights.

    No pair leads a group that was in an earlier one.
    """
    batch = np.arange(len(second_order))
    size = min(_GROUP_SIZE, second_order.shape[1] - 1)
    support = second_order.sum(axis=2)
    members, weights = [], []
    for _ in range(min(count, second_order.shape[1])):
        leaders = support.argmax(axis=1)
        supported = second_order[batch, leaders]
        others = np.argpartition(-supported, size, axis=1)[:, :size]
        masses = np.maximum(np.take_along_axis(supported, others, axis=1), 1e-3)
        members.append(np.concatenate([others, leaders[:, None]], axis=1))
        weights.append(np.concatenate([masses, masses.max(axis=1, keepdims=True)], axis=1))
        np.put_along_axis(support, others, -1, axis=1)
        support[batch, leaders] = -2
    return np.stack(members, axis=1), np.stack(weights, axis=1).astype(np.float64)


def axis_motions(query: PreparedSample, candidates: SampleStack) -> Motions:
    """Bring the principal axes of the two medial axes together, in every order and direction.

    Parameters
    ----------
    query : PreparedSample
    candidates : SampleStack

    Returns
    -------
    motions : Motions
        24 for each candidate.
    """
    own, count = query.axis, len(_AXIS_ROTATIONS)
    scales = _SIZE_RATIO * np.array([other.size / own.size for other in candidates.axes])
    rotations = np.array([other.axes.T @ _AXIS_ROTATIONS @ own.axes for other in candidates.axes])
    centers = np.array([other.center for other in candidates.axes])
    translations = centers[:, None] - scales[:, None, None] * (rotations @ own.center)
    rows = np.repeat(np.arange(len(scales)), count)
    return Motions(rows, np.repeat(scales, count), rotations.reshape(-1, 3, 3), translations.reshape(-1, 3))
