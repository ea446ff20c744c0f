# SPDX-License-Identifier: MIT
"""Alignment of a query with many candidates at once, from coarse to fine.

Many motions of each candidate are scored by few points; the best are refined by iterated closest points (Besl
and McKay 1992) with robust weights and a free scale, and scored by more points.

A motion is chosen by how much of *both* shapes it covers. The share of the query alone would favour a query
that is shrunk until it fits into anything.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.aligning.motions import Motions, axis_motions, joined, paired_motions
from shapegoogle_core.registration.aligning.sample_stack import SampleStack, alike
from shapegoogle_core.registration.aligning.scoring import (
    Resolution,
    best_motions,
    refined_motions,
    scores_of_both,
)
from shapegoogle_core.registration.alignment import Alignment, measure
from shapegoogle_core.registration.frames import Frame
from shapegoogle_core.registration.prepared_sample import PreparedSample
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["align", "align_all"]

_BOUNDS = 0.5, 2.3  # of the scale
_GROUPS = 6  # motions from pairs of points at each scale
_KEYPOINTS = 96  # of the query that are paired
# The scale that is guessed from the two axes, also somewhat smaller, is one of the powers of this ratio: the
# query is described anew for each scale.
_SCALE_RATIO = 1.15
_GUESSES = (1.0, 0.87)
# A guessed scale this near to another one is not tried.
_SAME_SCALE = 0.07
# Scores: the first one of all motions, the second one of those refined roughly.
_COARSE = Resolution(96, 32, 0.06)
_MEDIUM = Resolution(240, 80, 0.045)
# Number of motions of each candidate that are refined roughly, and then finely.
_ROUGHLY, _FINELY = 8, 3
# Steps of iterated closest points: number of the candidate's points, tolerance in units of its √area.
_ROUGH_STEPS = ((96, 0.16), (96, 0.12), (128, 0.09), (160, 0.07))
_FINE_STEPS = ((240, 0.05), (400, 0.04), (400, 0.03), (400, 0.02))


def align(query: PreparedSample, candidate: PreparedSample) -> Alignment:
    """Align a query with a candidate.

    Parameters
    ----------
    query, candidate : PreparedSample

    Returns
    -------
    alignment : Alignment
        The best one found; it need not be a good one.
    """
    return _known(align_all(query, [candidate.sample])[0])


def _known(alignment: Alignment | None) -> Alignment:
    """Return an alignment that covers nothing for a candidate onto which no motion was found."""
    if alignment is not None:
        return alignment
    return Alignment(Frame(1.0, np.eye(3), np.zeros(3)), *np.zeros((4, 3)))


def align_all(
    query: PreparedSample, candidates: Sequence[SurfaceSample], *, finely: int | None = None
) -> list[Alignment | None]:
    """Align a query with many candidates.

    Parameters
    ----------
    query : PreparedSample
        Tried at each of its scales, and at the scale at which its medial axis is as large as the candidate's.
    candidates : sequence of SurfaceSample
    finely : int, optional
        Number of candidates that are aligned finely, those that agree most after a rough alignment; all by
        default.

    Returns
    -------
    alignments : list of Alignment or None
        For each candidate the best one found, which does not depend on the others and need not be a good one;
        None for those that are not aligned finely, and where no motion was found.
    """
    stacks = [(group, SampleStack.of([candidates[place] for place in group])) for group in alike(candidates)]
    rough = [_rough_motions(query, stack) for _, stack in stacks]
    least = -np.inf
    if finely is not None and finely < len(candidates):
        best = np.concatenate(
            [scores[np.unique(motions.rows, return_index=True)[1]] for motions, scores in rough]
        )
        if finely < len(best):
            least = np.partition(best, -finely)[-finely] if finely else np.inf
    found: list[Alignment | None] = [None] * len(candidates)
    for (group, stack), (motions, scores) in zip(stacks, rough, strict=True):
        firsts = np.unique(motions.rows, return_index=True)[1]
        promising = motions.rows[firsts[scores[firsts] >= least]]
        motions = refined_motions(
            query, stack, motions[np.isin(motions.rows, promising)], _FINE_STEPS, _BOUNDS
        )
        for position, row in enumerate(motions.rows.tolist()):
            place = group[row]
            alignment = measure(query, PreparedSample(candidates[place]), motions.frame(position))
            best_one = found[place]
            if best_one is None or alignment.agreement > best_one.agreement:
                found[place] = alignment
    return found


def _rough_motions(query: PreparedSample, candidates: SampleStack) -> tuple[Motions, FloatArray]:
    """Find the best motions of each candidate, and refine them roughly; with their scores, best first."""
    motions = _possible(query, candidates).within(*_BOUNDS)
    motions, _ = best_motions(motions, scores_of_both(query, candidates, motions, _COARSE), _ROUGHLY)
    motions = refined_motions(query, candidates, motions, _ROUGH_STEPS, _BOUNDS)
    return best_motions(motions, scores_of_both(query, candidates, motions, _MEDIUM), _FINELY)


def _possible(query: PreparedSample, candidates: SampleStack) -> Motions:
    """List motions of each candidate, from pairs of points at several scales and from principal axes."""
    every = np.arange(len(candidates.points))
    motions = [axis_motions(query, candidates)]
    motions += [
        paired_motions(query, candidates, every, scale, _GROUPS, _KEYPOINTS) for scale in query.scales
    ]
    sizes = np.array([axis.size for axis in candidates.axes]) / query.axis.size
    for factor in _GUESSES:
        powers = np.rint(np.log(np.clip(factor * sizes, *_BOUNDS)) / np.log(_SCALE_RATIO)).astype(int)
        for power in np.unique(powers).tolist():
            scale = _SCALE_RATIO**power
            if all(abs(scale / known - 1) > _SAME_SCALE for known in query.scales):
                rows = np.flatnonzero(powers == power)
                motions.append(paired_motions(query, candidates, rows, scale, _GROUPS, _KEYPOINTS))
    return joined(motions)
