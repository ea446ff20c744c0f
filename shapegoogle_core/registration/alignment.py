# SPDX-License-Identifier: MIT
"""Laying a surface over another by a rotation, a translation and a scale, and how much of it is covered then.

Correspondences of points that look alike are mostly wrong, but the right ones agree with each other on
distances. Groups that do, in the second order (Chen et al. 2022, SC²-PCR), give candidates of the motion; the
best are refined by iterated closest points, robustly weighted and with the scale free.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = [
    "COMMON_AGREEMENT",
    "PART_SCALES",
    "SCALES",
    "SHARED_SCALES",
    "TOLERANCES",
    "Alignment",
    "Frame",
    "PreparedSample",
    "agreeing",
    "align",
    "correspondences",
    "measure",
    "motions",
]

TOLERANCES = (0.01, 0.02, 0.05)
"""At which the coverage is measured, in units of the candidate's √area."""

AXIS_TOLERANCES = (0.02, 0.035, 0.05)
"""The same for the axes, whose points are less exact."""

COMMON_AGREEMENT = 0.25
"""Agreement that any two shapes reach somehow; see `Alignment.agreement`."""

# All lengths below are in units of √area.
# So many of the query's points each with the one of the candidate's that looks most like it.
_QUERY_KEYPOINTS = 128
# Scales of the query that are tried. When both are scaled to unit area, a part is larger than in its whole,
# and what is not swollen of a swollen shape is smaller.
SCALES = (1.0, 0.85, 1.2, 0.7)
"""Of the query, tried in a search."""

PART_SCALES = (1.0, 0.85, 0.7, 0.6)
"""Tried where the query may be a part of the candidate, down to a third of it."""

SHARED_SCALES = (*SCALES, 0.6)
"""Tried where a search looks for shapes that share parts with the query."""

_LEAST_SCALE, _LARGEST_SCALE = 0.55, 1.8
# How well two correspondences must agree on the distance of their points, and of their balls' centres.
_AGREEMENT = 0.05
_GROUPS, _GROUP_SIZE = 12, 16
# Candidates of the motion are compared by this many points of the query at this tolerance.
_COMPARED_POINTS, _COMPARED_TOLERANCE = 96, 0.05
_REFINED = 2
_FEWEST = 8  # points that have a counterpart
# Steps of iterated closest points: how many of the query's points, and the tolerance.
_STEPS = ((80, 0.12), (80, 0.09), (120, 0.07), (120, 0.05), (240, 0.04), (240, 0.03), (240, 0.02))
# A point farther than this from any point of the other sample has no counterpart.
_FARTHEST = 0.07


@dataclass(frozen=True, eq=False)
class Frame:
    """x ↦ scale · rotation x + translation, from the units of one sample to those of another.

    Attributes
    ----------
    scale : float
    rotation : (3, 3) array
        With determinant -1 for a reflection.
    translation : (3,) array
    """

    scale: float
    rotation: FloatArray
    translation: FloatArray

    def of(self, points: FloatArray) -> FloatArray:
        """Move (n, 3) points."""
        return np.asarray(self.scale * points @ self.rotation.T + self.translation)

    def back(self, points: FloatArray) -> FloatArray:
        """Move (n, 3) points the other way."""
        return np.asarray((points - self.translation) @ self.rotation / self.scale)

    def inverse(self) -> Frame:
        """Return the frame that undoes this one."""
        back = self.rotation.T
        return Frame(1 / self.scale, back, -(back @ self.translation) / self.scale)


@dataclass(frozen=True, eq=False)
class Alignment:
    """A similarity transformation x ↦ scale · rotation x + translation of the query onto the candidate.

    Attributes
    ----------
    scale : float
    rotation : (3, 3) array
    translation : (3,) array
    query_covered, candidate_covered : (3,) arrays
        At each of `TOLERANCES` τ the share of one surface that lies on the other, from 0 to 1: the mean over
        its points of exp(-(r/τ)²) |n · n′|, with r the distance to the tangent plane at the nearest point of
        the other and n, n′ the normals there.
    query_axis_covered, candidate_axis_covered : (3,) arrays
        The same of the medial axes, with r the distance to the nearest point of the other and without
        normals: a swollen limb leaves its own surface, but not its axis.
    """

    scale: float
    rotation: FloatArray
    translation: FloatArray
    query_covered: FloatArray
    candidate_covered: FloatArray
    query_axis_covered: FloatArray
    candidate_axis_covered: FloatArray

    @property
    def frame(self) -> Frame:
        """The transformation itself."""
        return Frame(self.scale, self.rotation, self.translation)

    @property
    def agreement(self) -> float:
        """How well two shapes lie on one another, from 0 to 1.

        The geometric mean of both shares, averaged over the tolerances, and over surface and axis.
        """
        surface = np.sqrt(self.query_covered * self.candidate_covered)
        axis = np.sqrt(self.query_axis_covered * self.candidate_axis_covered)
        return float((surface.mean() + axis.mean()) / 2)

    @property
    def excess(self) -> float:
        """What both have in common beyond what any two surfaces have: max(0, agreement - 0.25)².

        Squared, for a middling agreement says little: a pose of the shape reaches it, and so does another
        individual in a like pose.
        """
        return max(0.0, self.agreement - COMMON_AGREEMENT) ** 2


class PreparedSample:
    """A sample with the search trees and distances that its alignment with many others needs.

    Parameters
    ----------
    sample : SurfaceSample
    scales : tuple of float, optional
        Scales at which it is tried as a query.
    """

    def __init__(self, sample: SurfaceSample, scales: tuple[float, ...] = SCALES) -> None:
        self.sample = sample
        self.scales = scales
        self.points = sample.points
        self.normals = sample.normals
        self.centers = sample.centers
        keypoints = len(sample.descriptors)
        self.key_points = sample.points[:keypoints].astype(np.float32)
        self.key_centers = self.centers[:keypoints].astype(np.float32)

    @cached_property
    def tree(self) -> cKDTree:
        """Finds nearest points."""
        return cKDTree(self.points)

    @cached_property
    def center_tree(self) -> cKDTree:
        """Finds nearest points of the medial axis."""
        return cKDTree(self.centers)

    @cached_property
    def looks(self) -> tuple[tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]], ...]:
        """As a query, at each scale: descriptors, and distances between their points and between centres."""
        few = slice(_QUERY_KEYPOINTS)
        points, centers = _distances(self.key_points[few]), _distances(self.key_centers[few])
        return tuple(
            (
                self.sample.descriptors_at(scale, _QUERY_KEYPOINTS),
                np.float32(scale) * points,
                np.float32(scale) * centers,
            )
            for scale in self.scales
        )

    @cached_property
    def half_squares(self) -> NDArray[np.float32]:
        """Of the lengths of the descriptors."""
        return np.asarray((self.sample.descriptors**2).sum(axis=1) / 2)


def _distances(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Distances (..., n, n) between all points of a set (..., n, 3), fast."""
    squares = (points**2).sum(axis=-1)
    squared = squares[..., :, None] + squares[..., None, :] - 2 * points @ points.swapaxes(-1, -2)
    distances: NDArray[np.float32] = np.sqrt(np.maximum(squared, 0, out=squared), out=squared)
    return distances


def align(query: PreparedSample, candidate: PreparedSample) -> Alignment:
    """Lay a surface over another one.

    Parameters
    ----------
    query, candidate : PreparedSample

    Returns
    -------
    alignment : Alignment
        The best one found, which need not be a good one.
    """
    found = [
        motions(query, candidate, *correspondences(query, candidate, scale))
        for scale in range(len(query.scales))
    ]
    scales, rotations, translations = (np.concatenate(parts) for parts in zip(*found, strict=True))
    possible = (scales > _LEAST_SCALE) & (scales < _LARGEST_SCALE)
    if not possible.any():
        return Alignment(1.0, np.eye(3), np.zeros(3), *np.zeros((4, 3)))
    scales, rotations, translations = scales[possible], rotations[possible], translations[possible]
    scores = _scores(query, candidate, scales, rotations, translations)
    refined = [
        _refine(query, candidate, Frame(float(scales[best]), rotations[best], translations[best]))
        for best in np.argsort(-scores)[:_REFINED]
    ]
    return measure(query, candidate, max(refined, key=lambda pair: pair[0])[1])


def motions(
    query: PreparedSample,
    candidate: PreparedSample,
    there: NDArray[np.intp],
    second_order: NDArray[np.float32],
    groups: int = _GROUPS,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Find motions on which groups of correspondences agree.

    Parameters
    ----------
    query, candidate : PreparedSample
    there, second_order : (k,) array of int, (k, k) array of float32
        From `correspondences`.
    groups : int, optional
        How many groups there are at most.

    Returns
    -------
    scales, rotations, translations : (g,), (g, 3, 3) and (g, 3) arrays
    """
    members = _groups(second_order, groups)
    weights = np.maximum(np.take_along_axis(second_order[members[:, -1]], members, axis=1), 1e-3)
    weights[:, -1] = weights.max(axis=1)
    counterparts = there[members]
    return similarity_transformations(
        np.concatenate([query.points[members], query.centers[members]], axis=1),
        np.concatenate([candidate.points[counterparts], candidate.centers[counterparts]], axis=1),
        np.tile(weights.astype(np.float64), 2),
    )


def correspondences(
    query: PreparedSample, candidate: PreparedSample, scale: int
) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """For each point of the query find the one that looks most like it, and how far such pairs agree.

    Two pairs do on the distance of their points and of their balls' centres.

    Parameters
    ----------
    query, candidate : PreparedSample
    scale : int
        Which of the query's scales.

    Returns
    -------
    there : (k,) array of int
        Keypoints of the candidate.
    second_order : (k, k) array of float32
        For two pairs that agree how many others agree with both, else 0.
    """
    looks, distances, center_distances = query.looks[scale]
    there = (candidate.half_squares - looks @ candidate.sample.descriptors.T).argmin(axis=1)
    first_order = agreeing(
        there,
        distances,
        center_distances,
        candidate.key_points[there],
        candidate.key_centers[there],
        _AGREEMENT,
    )
    return there, first_order * (first_order @ first_order)


def agreeing(
    there: NDArray[np.intp],
    distances: NDArray[np.float32],
    center_distances: NDArray[np.float32],
    points: NDArray[np.float32],
    centers: NDArray[np.float32],
    tolerance: float,
) -> NDArray[np.float32]:
    """Tell which correspondences agree with which.

    Parameters
    ----------
    there : (..., k) array of int
        What corresponds to each of k points of a query.
    distances, center_distances : (k, k) arrays
        Between those points, and between the centres of their balls.
    points, centers : (..., k, 3) arrays
        The points `there`, and the centres of their balls.
    tolerance : float

    Returns
    -------
    agree : (..., k, k) array of float32
        0 or 1.
    """
    agree = np.abs(distances - _distances(points)) < tolerance
    agree &= np.abs(center_distances - _distances(centers)) < tolerance
    # One counterpart of two says nothing.
    agree &= there[..., :, None] != there[..., None, :]
    return np.asarray(agree, np.float32)


def _groups(second_order: NDArray[np.float32], count: int) -> NDArray[np.int64]:
    """Correspondences that many others support, each with its strongest supporters; it comes last."""
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


def similarity_transformations(
    first: FloatArray, second: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Scales, rotations and translations that lay points over others, in least squares (Umeyama 1991).

    Minimises Σ_i w_i ‖s R p_i + t - q_i‖² for each of b sets.

    Parameters
    ----------
    first, second : (b, n, 3) arrays
        p and q.
    weights : (b, n) array
        w ≥ 0, not all 0 in a set.

    Returns
    -------
    scales : (b,) array
    rotations : (b, 3, 3) array
        Proper ones: no reflections.
    translations : (b, 3) array
    """
    weights = weights / weights.sum(axis=1, keepdims=True)
    first_mean = (weights[:, None] @ first)[:, 0]
    second_mean = (weights[:, None] @ second)[:, 0]
    first, second = first - first_mean[:, None], second - second_mean[:, None]
    covariances = (weights[..., None] * second).transpose(0, 2, 1) @ first
    left, values, right = np.linalg.svd(covariances)
    sign = np.sign(np.linalg.det(left) * np.linalg.det(right))
    left[:, :, 2] *= sign[:, None]
    values[:, 2] *= sign
    rotations = left @ right
    spread = (weights * (first**2).sum(axis=2)).sum(axis=1)
    scales = values.sum(axis=1) / np.maximum(spread, np.finfo(float).tiny)
    translations = second_mean - scales[:, None] * (rotations @ first_mean[..., None])[..., 0]
    return scales, rotations, translations


def _scores(
    query: PreparedSample,
    candidate: PreparedSample,
    scales: FloatArray,
    rotations: FloatArray,
    translations: FloatArray,
) -> FloatArray:
    scores = np.zeros(len(scales))
    for points, tree in ((query.points, candidate.tree), (query.centers, candidate.center_tree)):
        turned = points[:_COMPARED_POINTS] @ rotations.transpose(0, 2, 1)
        moved = scales[:, None, None] * turned + translations[:, None]
        reach = 2 * _COMPARED_TOLERANCE
        distances, _ = tree.query(moved.reshape(-1, 3), distance_upper_bound=reach)
        distances = np.minimum(distances, reach).reshape(len(scales), -1)
        scores += np.exp(-((distances / _COMPARED_TOLERANCE) ** 2)).mean(axis=1)
    return scores


def _refine(query: PreparedSample, candidate: PreparedSample, motion: Frame) -> tuple[float, Frame]:
    """Iterate closest points (Besl and McKay 1992) of the surfaces and of the medial axes together.

    Pairs are weighted by distance, those of the surfaces by the agreement of their normals too. Returns the
    mean weight before the last step, and the motion.
    """
    support = 0.0
    for count, tolerance in _STEPS:
        points, normals, centers = query.points[:count], query.normals[:count], query.centers[:count]
        distances, nearest = candidate.tree.query(motion.of(points))
        across, nearest_center = candidate.center_tree.query(motion.of(centers))
        agreement = ((normals @ motion.rotation.T) * candidate.normals[nearest]).sum(axis=1) ** 2
        weights = np.exp(-((np.concatenate([distances, across]) / tolerance) ** 2))
        weights[: len(points)] *= agreement
        support = float(weights.mean())
        if np.count_nonzero(weights > 0.1) < _FEWEST:
            return 0.0, motion
        scales, rotations, translations = similarity_transformations(
            np.concatenate([points, centers])[None],
            np.concatenate([candidate.points[nearest], candidate.centers[nearest_center]])[None],
            weights[None],
        )
        if not _LEAST_SCALE < scales[0] < _LARGEST_SCALE:
            return 0.0, motion
        motion = Frame(float(scales[0]), rotations[0], translations[0])
    return support, motion


def measure(query: PreparedSample, candidate: PreparedSample, motion: Frame) -> Alignment:
    """Measure how much two surfaces have in common where a motion lays the query over the candidate.

    Parameters
    ----------
    query, candidate : PreparedSample
    motion : Frame
        From the query to the candidate.

    Returns
    -------
    alignment : Alignment
    """
    points, normals = motion.of(query.points), query.normals @ motion.rotation.T
    _, nearest = candidate.tree.query(points)
    forth = _coverage(points, normals, candidate.points[nearest], candidate.normals[nearest])
    # The query's tree is in its own place: ask there.
    _, nearest = query.tree.query(motion.back(candidate.points))
    other = _coverage(candidate.points, candidate.normals, points[nearest], normals[nearest])
    distances, _ = candidate.center_tree.query(motion.of(query.centers))
    forth_axis = _near(np.asarray(distances))
    distances, _ = query.center_tree.query(motion.back(candidate.centers))
    other_axis = _near(motion.scale * np.asarray(distances))
    return Alignment(motion.scale, motion.rotation, motion.translation, forth, other, forth_axis, other_axis)


def _near(distances: FloatArray) -> FloatArray:
    return np.array([np.exp(-((distances / tau) ** 2)).mean() for tau in AXIS_TOLERANCES])


def _coverage(
    points: FloatArray, normals: FloatArray, counterparts: FloatArray, their_normals: FloatArray
) -> FloatArray:
    offsets = points - counterparts
    agreement = np.abs((normals * their_normals).sum(axis=1))
    agreement[(offsets**2).sum(axis=1) > _FARTHEST**2] = 0
    heights = (offsets * their_normals).sum(axis=1)
    return np.array([(np.exp(-((heights / tau) ** 2)) * agreement).mean() for tau in TOLERANCES])
