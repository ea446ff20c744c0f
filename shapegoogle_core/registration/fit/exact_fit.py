# SPDX-License-Identifier: MIT
"""Share of a surface that lies exactly on another one, from a sample of each.

A part lies exactly on its whole, but only roughly on a relative of the whole. The tolerances of `Alignment`,
1 to 5 % of √area, do not separate the two. Two samples never have the same points, and where a surface bends,
the points of one lie off the tangent planes of the other. But for two points p and q of a circle with normals
n and m, (p - q) · (n + m) = 0: this symmetric distance is exact to second order (Rusinkiewicz 2019).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.aligning.motions import joined, paired_motions
from shapegoogle_core.registration.aligning.sample_stack import SampleStack, alike
from shapegoogle_core.registration.aligning.scoring import (
    Resolution,
    best_motions,
    refined_motions,
    scores_of_query,
)
from shapegoogle_core.registration.frames import Frame, height_derivatives, stepped
from shapegoogle_core.registration.prepared_sample import PreparedSample
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["RoughPose", "fit_exactly", "rough_pose", "rough_poses"]

# All lengths in this module are in units of the candidate's √area.
# Rough pose: number of motions at each scale; number of the query's points, and tolerance.
_GROUPS = 8
_POINTS, _TOLERANCE = 64, 0.05
# Of many candidates: score by which some motions are refined, steps of that, and the score that decides.
_REFINED = 3
_ROUGH = Resolution(128, 40, 0.05)
_ROUGH_STEPS = ((200, 0.07), (200, 0.05))
_LESS_ROUGH = Resolution(400, 96, 0.03)
# Steps of the fit: number of the query's points, tolerance of the distances.
_STEPS = (
    (120, 0.1),
    (120, 0.06),
    (200, 0.04),
    (600, 0.03),
    (600, 0.02),
    (600, 0.012),
    (600, 0.012),
    (600, 0.008),
    (600, 0.008),
)
# Tolerance of points that lie on the other surface.
_EXACT = 0.005
# A point has no counterpart if the nearest point is farther to the side, or if its normal differs by 45°.
_ASIDE, _SMALLEST_COSINE = 0.07, 0.7
_FEWEST = 16  # points with a counterpart
_SMALLEST_SCALE, _LARGEST_SCALE = 0.4, 2.5


@dataclass(frozen=True, eq=False)
class RoughPose:
    """Rough position of a query on a candidate, found much faster than by `align`.

    Attributes
    ----------
    covered : float
        Share of the query's points that lie roughly on the candidate, from 0 to 1.
    frame : Frame or None
        From the query to the candidate; None if no position was found.
    """

    covered: float
    frame: Frame | None


def rough_pose(query: PreparedSample, candidate: PreparedSample) -> RoughPose:
    """Align a query fast and roughly with a candidate, of which it may be only a part.

    Parameters
    ----------
    query, candidate : PreparedSample

    Returns
    -------
    pose : RoughPose
        The one that puts the largest share of the query on the candidate, whatever else the candidate has.
    """
    stack, row = SampleStack.of([candidate.sample]), np.zeros(1, int)
    found = joined([paired_motions(query, stack, row, scale, _GROUPS) for scale in query.scales])
    motions = found.within(_SMALLEST_SCALE, _LARGEST_SCALE)
    if len(motions) == 0:
        return RoughPose(0.0, None)
    points, normals = query.points[:_POINTS], query.normals[:_POINTS]
    turns = motions.rotations.transpose(0, 2, 1)
    moved = motions.scales[:, None, None] * (points @ turns) + motions.translations[:, None]
    distances, nearest = candidate.tree.query(moved.reshape(-1, 3), distance_upper_bound=2 * _TOLERANCE)
    # A point without a neighbour gets an infinite distance and the index after the last one.
    nearest = np.minimum(nearest, len(candidate.points) - 1).reshape(moved.shape[:2])
    agreement = np.abs(((normals @ turns) * candidate.normals[nearest]).sum(axis=2))
    near = np.exp(-((np.asarray(distances).reshape(moved.shape[:2]) / _TOLERANCE) ** 2))
    covered = (near * agreement).mean(axis=1)
    first = int(covered.argmax())
    return RoughPose(float(covered[first]), motions.frame(first))


def rough_poses(
    query: PreparedSample, candidates: Sequence[SurfaceSample], scales_tried: Sequence[Collection[int]]
) -> list[RoughPose]:
    """Align a query fast and roughly with many candidates, each of which it may be a part of.

    More thorough than `rough_pose`, but slower for a query that is aligned with one candidate only.

    Parameters
    ----------
    query : PreparedSample
    candidates : sequence of SurfaceSample
    scales_tried : sequence of collection of int
        For each candidate, indices of the query's scales to try.

    Returns
    -------
    poses : list of RoughPose
        Independent of each other.
    """
    poses = [RoughPose(0.0, None)] * len(candidates)
    for group in alike(candidates):
        stack = SampleStack.of([candidates[place] for place in group])
        found = []
        for number, scale in enumerate(query.scales):
            rows = np.array([row for row, place in enumerate(group) if number in scales_tried[place]], int)
            if len(rows):
                found.append(paired_motions(query, stack, rows, scale, _GROUPS))
        if not found:
            continue
        motions = joined(found).within(_SMALLEST_SCALE, _LARGEST_SCALE)
        motions, _ = best_motions(motions, scores_of_query(query, stack, motions, _ROUGH), _REFINED)
        motions = refined_motions(query, stack, motions, _ROUGH_STEPS, (_SMALLEST_SCALE, _LARGEST_SCALE))
        motions, scores = best_motions(motions, scores_of_query(query, stack, motions, _LESS_ROUGH), 1)
        for position, row in enumerate(motions.rows.tolist()):
            poses[group[row]] = RoughPose(float(scores[position]), motions.frame(position))
    return poses


def fit_exactly(
    query: PreparedSample, candidate: PreparedSample, frame: Frame, *, hopeless: float = 0.0
) -> tuple[float, Frame]:
    """Fit a query to a candidate, and measure the share of it that lies exactly on the candidate.

    Gauss-Newton iterations on the symmetric distances, with robust weights and a free scale.

    Parameters
    ----------
    query, candidate : PreparedSample
    frame : Frame
        Initial frame from the query to the candidate.
    hopeless : float, optional
        Share of the query near the candidate below which the fit is not continued.

    Returns
    -------
    exact : float
        Mean over the query's points of exp(-(r/τ)²) with r the symmetric distance and τ = 0.005, from 0 to 1.
        Parts that only the candidate has do not lower it.
    frame : Frame
        The fitted frame.
    """
    for count, tolerance in _STEPS:
        arms, heights, normals, paired = _heights(query, candidate, frame, count)
        weights = np.exp(-((heights / tolerance) ** 2)) * paired
        if np.count_nonzero(weights > 0.1) < _FEWEST or (hopeless and weights.mean() < hopeless):
            break
        step = _step(frame, arms, normals, heights, weights)
        if not _SMALLEST_SCALE < step.scale < _LARGEST_SCALE:
            break
        frame = step
    _, heights, _, paired = _heights(query, candidate, frame, len(query.points))
    return float((np.exp(-((heights / _EXACT) ** 2)) * paired).mean()), frame


def _heights(
    query: PreparedSample, candidate: PreparedSample, frame: Frame, count: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the moved first points, their distances, the directions of these, and 1 for paired points."""
    points = frame.apply(query.points[:count])
    turned = query.normals[:count] @ frame.rotation.T
    distances, nearest = candidate.tree.query(points)
    counterpart_normals = candidate.normals[nearest]
    cosines = (turned * counterpart_normals).sum(axis=1)
    # The orientation of a sample's normals is arbitrary.
    normals = turned + np.where(cosines < 0, -1.0, 1.0)[:, None] * counterpart_normals
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    heights = ((points - candidate.points[nearest]) * normals).sum(axis=1)
    aside = np.sqrt(np.maximum(distances**2 - heights**2, 0))
    paired = (np.abs(cosines) > _SMALLEST_COSINE) & (aside < _ASIDE)
    return points, heights, normals, paired.astype(np.float64)


def _step(
    frame: Frame, points: FloatArray, normals: FloatArray, heights: FloatArray, weights: FloatArray
) -> Frame:
    middle = (weights @ points) / weights.sum()
    arms = points - middle
    columns = height_derivatives(arms, normals)
    squares = columns.T @ (weights[:, None] * columns)
    # Regularise motions that the surface leaves free, such as the rotation of a sphere.
    squares[np.diag_indices(7)] += 1e-6 * np.trace(squares)
    solution: FloatArray = np.linalg.solve(squares, -columns.T @ (weights * heights)).astype(np.float64)
    return stepped(frame, middle, solution, 0.9, 1.1)
