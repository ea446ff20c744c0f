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

__all__ = ["COMMON_AGREEMENT", "TOLERANCES", "Alignment", "Placed", "align"]

TOLERANCES = (0.01, 0.02, 0.05)
"""At which the coverage is measured, in units of the candidate's √area."""

COMMON_AGREEMENT = 0.2
"""Agreement that any two surfaces reach somehow; see `Alignment.agreement`."""

# All lengths below are in units of √area.
# So many of the query's points each with as many of the candidate's that look most like it.
_QUERY_KEYPOINTS, _LIKEST = 128, 2
# Scales of the query that are tried: a part is larger than in its whole, when both are scaled to unit area.
_SCALES = (1.0, 0.88)
_LEAST_SCALE, _LARGEST_SCALE = 0.55, 1.35
# How well two correspondences must agree on a distance.
_AGREEMENT = 0.04
_GROUPS, _GROUP_SIZE = 12, 16
# Candidates of the motion are compared by this many points of the query at this tolerance.
_COMPARED_POINTS, _COMPARED_TOLERANCE = 96, 0.05
_REFINED = 2
_FEWEST = 8  # points that have a counterpart
# Steps of iterated closest points: how many of the query's points, and the tolerance.
_STEPS = ((100, 0.12), (100, 0.09), (150, 0.07), (150, 0.05), (300, 0.04), (300, 0.03), (300, 0.02))
# A point farther than this from any point of the other sample has no counterpart.
_FARTHEST = 0.07


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
    """

    scale: float
    rotation: FloatArray
    translation: FloatArray
    query_covered: FloatArray
    candidate_covered: FloatArray

    @property
    def agreement(self) -> float:
        """How well the smaller of the two surfaces lies on the other, from 0 to 1.

        The larger of both shares, averaged over the tolerances: a part lies on its whole completely, the
        whole not on its part.
        """
        return float(np.maximum(self.query_covered, self.candidate_covered).mean())


@dataclass(frozen=True, eq=False)
class _Motion:
    scale: float
    rotation: FloatArray
    translation: FloatArray

    def of(self, points: FloatArray) -> FloatArray:
        moved: FloatArray = self.scale * points @ self.rotation.T + self.translation
        return moved

    def back(self, points: FloatArray) -> FloatArray:
        moved: FloatArray = (points - self.translation) @ self.rotation / self.scale
        return moved


class Placed:
    """A sample made ready to be aligned with many others."""

    def __init__(self, sample: SurfaceSample) -> None:
        self.points = sample.points
        self.normals = sample.normals
        self.descriptors = sample.descriptors
        self.key_points = sample.points[: len(sample.descriptors)].astype(np.float32)

    @cached_property
    def tree(self) -> cKDTree:
        """Finds nearest points."""
        return cKDTree(self.points)

    @cached_property
    def key_distances(self) -> NDArray[np.float32]:
        """(k, k) distances between the points with descriptors."""
        squares = (self.key_points**2).sum(axis=1)
        squared = squares[:, None] + squares[None] - 2 * self.key_points @ self.key_points.T
        distances: NDArray[np.float32] = np.sqrt(np.maximum(squared, 0))
        return distances


def align(query: Placed, candidate: Placed) -> Alignment:
    """Lay a surface over another one.

    Parameters
    ----------
    query, candidate : Placed

    Returns
    -------
    alignment : Alignment
        The best one found, which need not be a good one.
    """
    motions = [_motions(query, candidate, scale) for scale in _SCALES]
    scales, rotations, translations = (np.concatenate(parts) for parts in zip(*motions, strict=True))
    possible = (scales > _LEAST_SCALE) & (scales < _LARGEST_SCALE)
    if not possible.any():
        return Alignment(1.0, np.eye(3), np.zeros(3), np.zeros(3), np.zeros(3))
    scales, rotations, translations = scales[possible], rotations[possible], translations[possible]
    scores = _scores(query, candidate, scales, rotations, translations)
    refined = [
        _refine(query, candidate, _Motion(float(scales[best]), rotations[best], translations[best]))
        for best in np.argsort(-scores)[:_REFINED]
    ]
    return _measure(query, candidate, max(refined, key=lambda pair: pair[0])[1])


def _motions(query: Placed, candidate: Placed, scale: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Motions on which groups of correspondences agree, if the query is scaled by about `scale`."""
    looks = query.descriptors[:_QUERY_KEYPOINTS]
    unlikeness = (candidate.descriptors**2).sum(axis=1)[None] - 2 * looks @ candidate.descriptors.T
    likest = np.argpartition(unlikeness, _LIKEST, axis=1)[:, :_LIKEST]
    here = np.repeat(np.arange(len(looks)), _LIKEST)
    there = likest.ravel()
    query_distances = query.key_distances[: len(looks), : len(looks)].repeat(_LIKEST, 0).repeat(_LIKEST, 1)
    candidate_distances = candidate.key_distances[there[:, None], there]
    agree = np.abs(np.float32(scale) * query_distances - candidate_distances) < _AGREEMENT
    # Neither two counterparts of one point, nor one counterpart of two.
    agree &= (here[:, None] != here) & (there[:, None] != there)
    first_order = agree.astype(np.float32)
    second_order = first_order * (first_order @ first_order)
    groups = _groups(second_order)
    weights = np.maximum(np.take_along_axis(second_order[groups[:, -1]], groups, axis=1), 1e-3)
    weights[:, -1] = weights.max(axis=1)
    return similarity_transformations(
        query.points[here[groups]], candidate.points[there[groups]], weights.astype(np.float64)
    )


def _groups(second_order: NDArray[np.float32]) -> NDArray[np.int64]:
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
        if len(groups) == _GROUPS:
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
    query: Placed, candidate: Placed, scales: FloatArray, rotations: FloatArray, translations: FloatArray
) -> FloatArray:
    points = query.points[:_COMPARED_POINTS]
    moved = scales[:, None, None] * (points @ rotations.transpose(0, 2, 1)) + translations[:, None]
    reach = 2 * _COMPARED_TOLERANCE
    distances, _ = candidate.tree.query(moved.reshape(-1, 3), distance_upper_bound=reach)
    distances = np.minimum(distances, reach).reshape(len(scales), -1)
    scores: FloatArray = np.exp(-((distances / _COMPARED_TOLERANCE) ** 2)).mean(axis=1)
    return scores


def _refine(query: Placed, candidate: Placed, motion: _Motion) -> tuple[float, _Motion]:
    """Iterate closest points (Besl and McKay 1992), weighted by distance and by agreement of the normals.

    Returns the mean weight at the last tolerance, and the motion.
    """
    support = 0.0
    for count, tolerance in _STEPS:
        points, normals = query.points[:count], query.normals[:count]
        distances, nearest = candidate.tree.query(motion.of(points))
        agreement = ((normals @ motion.rotation.T) * candidate.normals[nearest]).sum(axis=1) ** 2
        weights = np.exp(-((distances / tolerance) ** 2)) * agreement
        support = float(weights.mean())
        if np.count_nonzero(weights > 0.1) < _FEWEST:
            return 0.0, motion
        scales, rotations, translations = similarity_transformations(
            points[None], candidate.points[nearest][None], weights[None]
        )
        if not _LEAST_SCALE < scales[0] < _LARGEST_SCALE:
            return 0.0, motion
        motion = _Motion(float(scales[0]), rotations[0], translations[0])
    return support, motion


def _measure(query: Placed, candidate: Placed, motion: _Motion) -> Alignment:
    points, normals = motion.of(query.points), query.normals @ motion.rotation.T
    _, nearest = candidate.tree.query(points)
    forth = _coverage(points, normals, candidate.points[nearest], candidate.normals[nearest])
    # The query's tree is in its own place: ask there.
    _, nearest = query.tree.query(motion.back(candidate.points))
    other = _coverage(candidate.points, candidate.normals, points[nearest], normals[nearest])
    return Alignment(motion.scale, motion.rotation, motion.translation, forth, other)


def _coverage(
    points: FloatArray, normals: FloatArray, counterparts: FloatArray, their_normals: FloatArray
) -> FloatArray:
    offsets = points - counterparts
    agreement = np.abs((normals * their_normals).sum(axis=1))
    agreement[(offsets**2).sum(axis=1) > _FARTHEST**2] = 0
    heights = (offsets * their_normals).sum(axis=1)
    return np.array([(np.exp(-((heights / tau) ** 2)) * agreement).mean() for tau in TOLERANCES])
