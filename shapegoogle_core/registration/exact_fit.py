# SPDX-License-Identifier: MIT
"""How much of a surface lies exactly on another one, as far as two samples of both can tell.

A part lies on its whole to a hair, on a relative of it only roughly: what `Alignment` measures with
tolerances of 1 to 5 % of √area does not tell them apart. Two samples never have the same points, and where a
surface bends, the points of one lie off the tangent planes of the other. But of two points p and q of a
circle with normals n and m, (p - q) · (n + m) = 0: this distance is exact to the second order (Rusinkiewicz
2019).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.alignment import Frame, PreparedSample, correspondences, motions
from shapegoogle_core.registration.gauss_newton import height_derivatives, step_of

__all__ = ["RoughPose", "exact_fit", "rough_pose"]

# Lengths are in units of the candidate's √area.
# A rough pose is looked for from so many groups of correspondences at each scale; by so many of the query's
# points at this tolerance.
_GROUPS = 8
_POINTS, _TOLERANCE = 64, 0.05
# Steps of the fit: how many of the query's points, and the tolerance of the distances.
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
# Lying on the other surface means this near.
_EXACT = 0.005
# Points have no counterpart beside this, or if normals differ by more than 45°.
_ASIDE, _LEAST_COSINE = 0.07, 0.7
_FEWEST = 16
_LEAST_SCALE, _LARGEST_SCALE = 0.4, 2.5


@dataclass(frozen=True, eq=False)
class RoughPose:
    """Where a query lies on a candidate, found in a tenth of the time that `align` takes.

    Attributes
    ----------
    covered : float
        Share of the query's points that lie roughly on the candidate, from 0 to 1.
    frame : Frame or None
        From the query to the candidate; None where there is none.
    """

    covered: float
    frame: Frame | None


def rough_pose(
    query: PreparedSample, candidate: PreparedSample, among: Sequence[int] | None = None
) -> RoughPose:
    """Lay a query over a candidate that may have more than it, fast and roughly.

    Parameters
    ----------
    query, candidate : PreparedSample
    among : sequence of int, optional
        Which of the query's scales are tried; all, if it is not given.

    Returns
    -------
    pose : RoughPose
        The best one by what lies on the candidate of the query; not by the other way round.
    """
    tried = range(len(query.scales)) if among is None else among
    best = RoughPose(0.0, None)
    points, normals = query.points[:_POINTS], query.normals[:_POINTS]
    for scale in tried:
        there, second_order = correspondences(query, candidate, scale)
        scales, rotations, translations = motions(query, candidate, there, second_order, _GROUPS)
        possible = (scales > _LEAST_SCALE) & (scales < _LARGEST_SCALE)
        if not possible.any():
            continue
        scales, rotations, translations = scales[possible], rotations[possible], translations[possible]
        turns = rotations.transpose(0, 2, 1)
        moved = scales[:, None, None] * (points @ turns) + translations[:, None]
        reach = 2 * _TOLERANCE
        distances, nearest = candidate.tree.query(moved.reshape(-1, 3), distance_upper_bound=reach)
        # Those without a neighbour have the number after the last one, and count for nothing.
        nearest = np.minimum(nearest, len(candidate.points) - 1).reshape(moved.shape[:2])
        agreement = np.abs(((normals @ turns) * candidate.normals[nearest]).sum(axis=2))
        near = np.exp(-((np.asarray(distances).reshape(moved.shape[:2]) / _TOLERANCE) ** 2))
        covered = (near * agreement).mean(axis=1)
        first = int(covered.argmax())
        if covered[first] > best.covered:
            frame = Frame(float(scales[first]), rotations[first], translations[first])
            best = RoughPose(float(covered[first]), frame)
    return best


def exact_fit(query: PreparedSample, candidate: PreparedSample, frame: Frame) -> tuple[float, Frame]:
    """Fit a query to a candidate, and tell how much of it lies exactly there.

    Gauss and Newton's method on the distances of the head of this module, robustly weighted, with the scale
    free.

    Parameters
    ----------
    query, candidate : PreparedSample
    frame : Frame
        From the query to the candidate, to start from.

    Returns
    -------
    exact : float
        Mean over the query's points of exp(-(r/τ)²) with r the distance and τ = 0.005, from 0 to 1. What a
        candidate has besides does not lower it.
    frame : Frame
        Where it is so.
    """
    for count, tolerance in _STEPS:
        arms, heights, normals, paired = _heights(query, candidate, frame, count)
        weights = np.exp(-((heights / tolerance) ** 2)) * paired
        if np.count_nonzero(weights > 0.1) < _FEWEST:
            break
        step = _step(frame, arms, normals, heights, weights)
        if not _LEAST_SCALE < step.scale < _LARGEST_SCALE:
            break
        frame = step
    _, heights, _, paired = _heights(query, candidate, frame, len(query.points))
    return float((np.exp(-((heights / _EXACT) ** 2)) * paired).mean()), frame


def _heights(
    query: PreparedSample, candidate: PreparedSample, frame: Frame, count: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Of the query's first points: where they are, their distances, along what, and 1 for the paired ones."""
    points = frame.of(query.points[:count])
    turned = query.normals[:count] @ frame.rotation.T
    distances, nearest = candidate.tree.query(points)
    theirs = candidate.normals[nearest]
    cosines = (turned * theirs).sum(axis=1)
    # Which side a normal is on means nothing.
    normals = turned + np.where(cosines < 0, -1.0, 1.0)[:, None] * theirs
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    heights = ((points - candidate.points[nearest]) * normals).sum(axis=1)
    aside = np.sqrt(np.maximum(distances**2 - heights**2, 0))
    paired = (np.abs(cosines) > _LEAST_COSINE) & (aside < _ASIDE)
    return points, heights, normals, paired.astype(np.float64)


def _step(
    frame: Frame, points: FloatArray, normals: FloatArray, heights: FloatArray, weights: FloatArray
) -> Frame:
    middle = (weights @ points) / weights.sum()
    arms = points - middle
    columns = height_derivatives(arms, normals)
    squares = columns.T @ (weights[:, None] * columns)
    # What the surface does not tell, such as a turn of a sphere, stays as it is.
    squares[np.diag_indices(7)] += 1e-6 * np.trace(squares)
    solution: FloatArray = np.linalg.solve(squares, -columns.T @ (weights * heights)).astype(np.float64)
    return step_of(frame, middle, solution, 0.9, 1.1)
