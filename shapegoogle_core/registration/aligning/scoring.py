# SPDX-License-Identifier: MIT
"""Scores of many motions of a query onto many candidates, and their refinement.

Points of the candidates are moved to the query, whose nearest points are looked up in a `NearestField`, so
that nothing is prepared for a candidate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.aligning.motions import Motions
from shapegoogle_core.registration.aligning.nearest_field import NearestField
from shapegoogle_core.registration.aligning.sample_stack import SampleStack
from shapegoogle_core.registration.frames import similarity_transformations
from shapegoogle_core.registration.prepared_sample import PreparedSample

__all__ = [
    "Resolution",
    "best_motions",
    "refined_motions",
    "scores_of_both",
    "scores_of_candidates",
    "scores_of_query",
]

# A motion needs this many points with a counterpart, of at least this weight.
_FEWEST, _COUNTS = 8, 0.1
_REACHED = 0.6  # share of the expected hits from which a cell counts as covered
_MOTIONS_AT_ONCE = 512


@dataclass(frozen=True)
class Resolution:
    """Precision of a score.

    Attributes
    ----------
    points : int
        Number of the candidate's points.
    cells : int
        Number of cells of the query, each around one of its points.
    tolerance : float
        In units of the candidate's √area.
    """

    points: int
    cells: int
    tolerance: float


def best_motions(motions: Motions, scores: FloatArray, count: int) -> tuple[Motions, FloatArray]:
    """Keep the best motions of each candidate.

    Parameters
    ----------
    motions : Motions
    scores : (h,) array
    count : int
        Maximum number for each candidate.

    Returns
    -------
    motions, scores : Motions, array
        Candidate by candidate, best first.
    """
    order = np.lexsort((-scores, motions.rows))
    rows = motions.rows[order]
    starts = np.flatnonzero(np.append(True, rows[1:] != rows[:-1])) if len(rows) else np.zeros(0, int)
    places = np.arange(len(rows)) - np.repeat(starts, np.diff(np.append(starts, len(rows))))
    kept = order[places < count]
    return motions[kept], scores[kept]


def _moved_back(points: NDArray[np.float32], motions: Motions) -> NDArray[np.float32]:
    """Move (h, n, 3) points of the candidates to the query."""
    shifted = points - motions.translations[:, None].astype(np.float32)
    moved = shifted @ motions.rotations.astype(np.float32)
    return np.asarray(moved / motions.scales[:, None, None].astype(np.float32))


def scores_of_both(
    query: PreparedSample, candidates: SampleStack, motions: Motions, resolution: Resolution
) -> FloatArray:
    """Score motions by the shares of both shapes that they cover, of the surfaces and of the medial axes.

    Parameters
    ----------
    query : PreparedSample
    candidates : SampleStack
    motions : Motions
    resolution : Resolution

    Returns
    -------
    scores : (h,) array
        Geometric means of the two shares, averaged over surface and axis; about `Alignment.agreement`.
    """
    surface = _shares(query, candidates, motions, resolution, of_surface=True)
    axis = _shares(query, candidates, motions, resolution, of_surface=False)
    return np.asarray((np.sqrt(surface.prod(axis=0)) + np.sqrt(axis.prod(axis=0))) / 2)


def scores_of_candidates(
    query: PreparedSample, candidates: SampleStack, motions: Motions, resolution: Resolution
) -> FloatArray:
    """Score motions by the share of the candidate's surface that lies on the query, whatever else that has.

    Parameters
    ----------
    query : PreparedSample
    candidates : SampleStack
    motions : Motions
    resolution : Resolution

    Returns
    -------
    scores : (h,) array
    """
    return np.asarray(_shares(query, candidates, motions, resolution, of_surface=True)[0])


def scores_of_query(
    query: PreparedSample, candidates: SampleStack, motions: Motions, resolution: Resolution
) -> FloatArray:
    """Score motions by the share of the query's surface that lies on the candidate, whatever else that has.

    Parameters
    ----------
    query : PreparedSample
    candidates : SampleStack
    motions : Motions
    resolution : Resolution

    Returns
    -------
    scores : (h,) array
    """
    return np.asarray(_shares(query, candidates, motions, resolution, of_surface=True)[1])


def _shares(
    query: PreparedSample,
    candidates: SampleStack,
    motions: Motions,
    resolution: Resolution,
    *,
    of_surface: bool,
) -> FloatArray:
    """Return the (2, h) shares of the candidates and of the query that lie on the other one."""
    count = min(resolution.points, candidates.points.shape[1])
    cells = min(resolution.cells, len(query.points))
    labels = query.cells(cells)
    field = query.field if of_surface else query.center_field
    everything = candidates.points if of_surface else candidates.centers
    shares = np.zeros((2, len(motions)))
    for start in range(0, len(motions), _MOTIONS_AT_ONCE):
        some = motions[np.arange(start, min(start + _MOTIONS_AT_ONCE, len(motions)))]
        weights, nearest, _ = _near(field, everything[some.rows, :count], some, resolution.tolerance)
        if of_surface:
            weights *= np.abs(_cosines(query, candidates, some, nearest))
        places = labels.take(nearest) + (cells + 1) * np.arange(len(some))[:, None]
        hits = np.bincount(places.ravel(), weights.ravel(), (cells + 1) * len(some))
        # The hits of a cell that is covered: a smaller query has fewer of the candidate's points.
        expected = _REACHED * np.maximum(count / cells * some.scales**2, 0.5)
        reached = np.minimum(hits.reshape(len(some), -1)[:, :cells] / expected[:, None], 1)
        part = slice(start, start + len(some))
        shares[0, part], shares[1, part] = weights.mean(axis=1), reached.mean(axis=1)
    return shares


def _cosines(
    query: PreparedSample, candidates: SampleStack, motions: Motions, nearest: NDArray[np.int32]
) -> NDArray[np.float32]:
    """Return the cosines between the normals of the first points and those of the nearest points."""
    turned = candidates.normals[motions.rows, : nearest.shape[1]] @ motions.rotations.astype(np.float32)
    return np.asarray(np.einsum("hni,hni->hn", turned, query.field_normals.take(nearest, axis=0)))


def _near(
    field: NearestField, points: NDArray[np.float32], motions: Motions, tolerance: float
) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.float32]]:
    """Weigh points by their distance from the query; return the nearest ones too, and their positions."""
    moved = _moved_back(points, motions)
    nearest = field.nearest(moved)
    counterparts = field.points.take(nearest, axis=0)
    moved -= counterparts
    factors = -((motions.scales / tolerance) ** 2)
    squares = np.einsum("hni,hni->hn", moved, moved)
    return np.exp(squares * factors[:, None].astype(np.float32)), nearest, counterparts


def refined_motions(
    query: PreparedSample,
    candidates: SampleStack,
    motions: Motions,
    steps: Sequence[tuple[int, float]],
    bounds: tuple[float, float],
) -> Motions:
    """Iterate closest points of the surfaces and of the medial axes together.

    Pairs are weighted by distance, those of the surfaces by the agreement of their normals too.

    Parameters
    ----------
    query : PreparedSample
    candidates : SampleStack
    motions : Motions
    steps : sequence of (int, float)
        Number of the candidate's points, and tolerance in units of its √area, of each step.
    bounds : (float, float)
        Smallest and largest scale.

    Returns
    -------
    motions : Motions
        Without those that lose the other shape or leave the bounds.
    """
    for count, tolerance in steps:
        points, centers = (array[motions.rows, :count] for array in (candidates.points, candidates.centers))
        weights, nearest, counterparts = _near(query.field, points, motions, tolerance)
        weights *= _cosines(query, candidates, motions, nearest) ** 2
        center_weights, _, center_counterparts = _near(query.center_field, centers, motions, tolerance)
        center_weights *= candidates.lengths[motions.rows, :count]
        weights = np.concatenate([weights, center_weights], axis=1)
        usable = np.count_nonzero(weights > _COUNTS, axis=1) >= _FEWEST
        fitted = similarity_transformations(
            np.concatenate([counterparts, center_counterparts], axis=1)[usable].astype(np.float64),
            np.concatenate([points, centers], axis=1)[usable].astype(np.float64),
            weights[usable].astype(np.float64),
        )
        motions = Motions(motions.rows[usable], *fitted).within(*bounds)
    return motions
