# SPDX-License-Identifier: MIT
"""Share of a surface that lies exactly on another one, from a sample of each.

A part lies exactly on its whole, but only roughly on a relative of the whole. The tolerances of `Alignment`,
1 to 5 % of √area, do not separate the two. Two samples never have the same points, and where a surface bends,
the points of one lie off the tangent planes of the other. But for two points p and q of a circle with normals
n and m, (p - q) · (n + m) = 0: this symmetric distance is exact to second order (Rusinkiewicz 2019).
"""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh.measures import dots, lengths
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.frames import Frame, height_derivatives, stepped
from shapegoogle_core.registration.prepared_sample import PreparedSample

__all__ = ["fit_exactly"]

# All lengths in this module are in units of the candidate's √area.
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
    cosines = dots(turned, counterpart_normals)
    # The orientation of a sample's normals is arbitrary.
    normals = turned + np.where(cosines < 0, -1.0, 1.0)[:, None] * counterpart_normals
    normals /= lengths(normals)[:, None]
    heights = dots(points - candidate.points[nearest], normals)
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
