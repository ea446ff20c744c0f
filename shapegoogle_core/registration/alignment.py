# SPDX-License-Identifier: MIT
"""Alignment of two samples by a similarity transformation, and how much of each surface lies on the other.

Candidates of the motion come from groups of keypoints (see `correspondences`). The best ones are refined by
iterated closest points (Besl and McKay 1992) with robust weights and a free scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.correspondences import correspondences, motions
from shapegoogle_core.registration.frames import Frame, similarity_frame
from shapegoogle_core.registration.prepared_sample import PreparedSample

__all__ = ["AXIS_TOLERANCES", "COMMON_AGREEMENT", "TOLERANCES", "Alignment", "align", "measure"]

# All lengths in this module are in units of the candidate's √area.
TOLERANCES = (0.01, 0.02, 0.05)
"""Tolerances of the coverage of the surface."""

AXIS_TOLERANCES = (0.02, 0.035, 0.05)
"""Tolerances of the coverage of the medial axis, whose points are less exact."""

COMMON_AGREEMENT = 0.25
"""Agreement that even unrelated shapes reach; see `Alignment.excess`."""

_SMALLEST_SCALE, _LARGEST_SCALE = 0.55, 1.8
# Candidates of the motion are compared on this many points of the query, at this tolerance.
_COMPARED_POINTS, _COMPARED_TOLERANCE = 96, 0.05
_REFINED = 2  # best candidates that are refined
_FEWEST = 8  # points with a counterpart
# Steps of iterated closest points: number of the query's points, tolerance.
_STEPS = ((80, 0.12), (80, 0.09), (120, 0.07), (120, 0.05), (240, 0.04), (240, 0.03), (240, 0.02))
# A point farther than this from all points of the other sample has no counterpart.
_FARTHEST = 0.07


@dataclass(frozen=True, eq=False)
class Alignment:
    """Motion of a query onto a candidate, with the share of each that lies on the other.

    Attributes
    ----------
    frame : Frame
        From the query's sample to the candidate's.
    query_covered, candidate_covered : (3,) arrays
        Share of one surface that lies on the other, from 0 to 1, at each τ of `TOLERANCES`: the mean over its
        points of exp(-(r/τ)²) |n · n′|, with r the distance to the tangent plane at the nearest point of the
        other surface, and n, n′ the normals there.
    query_axis_covered, candidate_axis_covered : (3,) arrays
        The same for the medial axes at `AXIS_TOLERANCES`, with r the distance to the nearest point of the
        other axis and without normals: a swollen limb leaves its own surface, but not its axis.
    """

    frame: Frame
    query_covered: FloatArray
    candidate_covered: FloatArray
    query_axis_covered: FloatArray
    candidate_axis_covered: FloatArray

    @property
    def agreement(self) -> float:
        """Agreement of the two surfaces, from 0 to 1.

        Geometric mean of both shares, averaged over the tolerances, and over surface and axis.
        """
        surface = np.sqrt(self.query_covered * self.candidate_covered)
        axis = np.sqrt(self.query_axis_covered * self.candidate_axis_covered)
        return float((surface.mean() + axis.mean()) / 2)

    @property
    def excess(self) -> float:
        """Agreement beyond that of unrelated surfaces: max(0, agreement - 0.25)².

        Squared because a moderate agreement is weak evidence: another pose of the shape reaches it, and so
        does another individual in a similar pose.
        """
        return max(0.0, self.agreement - COMMON_AGREEMENT) ** 2


def align(query: PreparedSample, candidate: PreparedSample) -> Alignment:
    """Align a query with a candidate.

    Parameters
    ----------
    query, candidate : PreparedSample
        The query is tried at each of its `scales`.

    Returns
    -------
    alignment : Alignment
        The best one found; it need not be a good one.
    """
    found = [
        motions(query, candidate, *correspondences(query, candidate, scale))
        for scale in range(len(query.scales))
    ]
    scales, rotations, translations = (np.concatenate(parts) for parts in zip(*found, strict=True))
    possible = (scales > _SMALLEST_SCALE) & (scales < _LARGEST_SCALE)
    if not possible.any():
        return Alignment(Frame(1.0, np.eye(3), np.zeros(3)), *np.zeros((4, 3)))
    scales, rotations, translations = scales[possible], rotations[possible], translations[possible]
    scores = _scores(query, candidate, scales, rotations, translations)
    refined = [
        _refine(query, candidate, Frame(float(scales[best]), rotations[best], translations[best]))
        for best in np.argsort(-scores)[:_REFINED]
    ]
    return measure(query, candidate, max(refined, key=lambda pair: pair[0])[1])


def measure(query: PreparedSample, candidate: PreparedSample, frame: Frame) -> Alignment:
    """Measure how much of each surface lies on the other in a given position.

    Parameters
    ----------
    query, candidate : PreparedSample
    frame : Frame
        From the query to the candidate.

    Returns
    -------
    alignment : Alignment
    """
    points, normals = frame.apply(query.points), query.normals @ frame.rotation.T
    _, nearest = candidate.tree.query(points)
    query_covered = _coverage(points, normals, candidate.points[nearest], candidate.normals[nearest])
    # The query's search tree is in the query's units.
    _, nearest = query.tree.query(frame.apply_inverse(candidate.points))
    candidate_covered = _coverage(candidate.points, candidate.normals, points[nearest], normals[nearest])
    distances, _ = candidate.center_tree.query(frame.apply(query.centers))
    query_axis_covered = _axis_coverage(np.asarray(distances))
    distances, _ = query.center_tree.query(frame.apply_inverse(candidate.centers))
    candidate_axis_covered = _axis_coverage(frame.scale * np.asarray(distances))
    return Alignment(frame, query_covered, candidate_covered, query_axis_covered, candidate_axis_covered)


def _scores(
    query: PreparedSample,
    candidate: PreparedSample,
    scales: FloatArray,
    rotations: FloatArray,
    translations: FloatArray,
) -> FloatArray:
    """Score motions by how near some of the query's points and ball centres come to the candidate's."""
    scores = np.zeros(len(scales))
    for points, tree in ((query.points, candidate.tree), (query.centers, candidate.center_tree)):
        turned = points[:_COMPARED_POINTS] @ rotations.transpose(0, 2, 1)
        moved = scales[:, None, None] * turned + translations[:, None]
        reach = 2 * _COMPARED_TOLERANCE
        distances, _ = tree.query(moved.reshape(-1, 3), distance_upper_bound=reach)
        distances = np.minimum(distances, reach).reshape(len(scales), -1)
        scores += np.exp(-((distances / _COMPARED_TOLERANCE) ** 2)).mean(axis=1)
    return scores


def _refine(query: PreparedSample, candidate: PreparedSample, frame: Frame) -> tuple[float, Frame]:
    """Iterate closest points of the surfaces and of the medial axes together.

    Pairs are weighted by distance, those of the surfaces by the agreement of their normals too. Returns the
    mean weight before the last step, and the frame.
    """
    support = 0.0
    for count, tolerance in _STEPS:
        points, normals, centers = query.points[:count], query.normals[:count], query.centers[:count]
        distances, nearest = candidate.tree.query(frame.apply(points))
        center_distances, nearest_center = candidate.center_tree.query(frame.apply(centers))
        agreement = ((normals @ frame.rotation.T) * candidate.normals[nearest]).sum(axis=1) ** 2
        weights = np.exp(-((np.concatenate([distances, center_distances]) / tolerance) ** 2))
        weights[: len(points)] *= agreement
        support = float(weights.mean())
        if np.count_nonzero(weights > 0.1) < _FEWEST:
            return 0.0, frame
        counterparts = np.concatenate([candidate.points[nearest], candidate.centers[nearest_center]])
        step = similarity_frame(np.concatenate([points, centers]), counterparts, weights)
        if not _SMALLEST_SCALE < step.scale < _LARGEST_SCALE:
            return 0.0, frame
        frame = step
    return support, frame


def _coverage(
    points: FloatArray, normals: FloatArray, counterparts: FloatArray, counterpart_normals: FloatArray
) -> FloatArray:
    offsets = points - counterparts
    agreement = np.abs((normals * counterpart_normals).sum(axis=1))
    agreement[(offsets**2).sum(axis=1) > _FARTHEST**2] = 0
    heights = (offsets * counterpart_normals).sum(axis=1)
    return np.array([(np.exp(-((heights / tau) ** 2)) * agreement).mean() for tau in TOLERANCES])


def _axis_coverage(distances: FloatArray) -> FloatArray:
    return np.array([np.exp(-((distances / tau) ** 2)).mean() for tau in AXIS_TOLERANCES])
