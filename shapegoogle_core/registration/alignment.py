# SPDX-License-Identifier: MIT
"""How much of each of two surfaces lies on the other after a similarity transformation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.frames import Frame
from shapegoogle_core.registration.prepared_sample import PreparedSample

__all__ = ["AXIS_TOLERANCES", "COMMON_AGREEMENT", "TOLERANCES", "Alignment", "measure"]

# All lengths in this module are in units of the candidate's √area.
TOLERANCES = (0.01, 0.02, 0.05)
"""Tolerances of the coverage of the surface."""

AXIS_TOLERANCES = (0.02, 0.035, 0.05)
"""Tolerances of the coverage of the medial axis, whose points are less exact."""

COMMON_AGREEMENT = 0.25
"""Agreement that even unrelated shapes reach; see `Alignment.excess`."""

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
    on_candidate, on_query = _nearest(points, candidate.points)
    query_covered = _coverage(
        points, normals, candidate.points[on_candidate], candidate.normals[on_candidate]
    )
    candidate_covered = _coverage(candidate.points, candidate.normals, points[on_query], normals[on_query])
    centers = frame.apply(query.centers)
    on_candidate, on_query = _nearest(centers, candidate.centers)
    query_axis_covered = _axis_coverage(centers - candidate.centers[on_candidate])
    candidate_axis_covered = _axis_coverage(candidate.centers - centers[on_query])
    return Alignment(frame, query_covered, candidate_covered, query_axis_covered, candidate_axis_covered)


def _nearest(first: FloatArray, second: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Find the nearest one of each other's points; for hundreds of points faster than two search trees."""
    there, here = first.astype(np.float32), second.astype(np.float32)
    return _most_near(there, here), _most_near(here, there)


def _most_near(points: NDArray[np.float32], others: NDArray[np.float32]) -> NDArray[np.intp]:
    """Find the nearest of the others: the least |o|² / 2 - p · o, as one product."""
    half_squares = (others**2).sum(axis=1, keepdims=True) / 2
    ones = np.ones((len(points), 1), np.float32)
    products = np.concatenate([points, ones], axis=1) @ np.concatenate([others, -half_squares], axis=1).T
    return np.asarray(products.argmax(axis=1))


def _coverage(
    points: FloatArray, normals: FloatArray, counterparts: FloatArray, counterpart_normals: FloatArray
) -> FloatArray:
    offsets = points - counterparts
    agreement = np.abs((normals * counterpart_normals).sum(axis=1))
    agreement[(offsets**2).sum(axis=1) > _FARTHEST**2] = 0
    heights = (offsets * counterpart_normals).sum(axis=1)
    return np.array([(np.exp(-((heights / tau) ** 2)) * agreement).mean() for tau in TOLERANCES])


def _axis_coverage(offsets: FloatArray) -> FloatArray:
    squares = (offsets**2).sum(axis=1)
    return np.array([np.exp(-squares / tau**2).mean() for tau in AXIS_TOLERANCES])
