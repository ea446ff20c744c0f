# SPDX-License-Identifier: MIT
"""Rough positions of a query on many candidates at once, or of the candidates on the query.

They decide which pairs of shapes are worth an exact fit: most have nothing in common.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.aligning.motions import Motions, joined, paired_motions, reverse_motions
from shapegoogle_core.registration.aligning.sample_stack import SampleStack, alike
from shapegoogle_core.registration.aligning.scoring import (
    Resolution,
    best_motions,
    refined_motions,
    scores_of_candidates,
    scores_of_query,
)
from shapegoogle_core.registration.frames import Frame
from shapegoogle_core.registration.prepared_sample import PreparedSample
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["RoughPose", "rough_poses", "rough_poses_back"]

# All lengths in this module are in units of the candidate's √area.
# Number of motions at each scale, and of keypoints of a candidate that are paired with the query's.
_GROUPS, _KEYPOINTS = 8, 128
# Number of motions that are refined, score by which they are chosen, steps, and the score that decides.
_REFINED = 3
_ROUGH = Resolution(128, 40, 0.05)
_ROUGH_STEPS = ((200, 0.07), (200, 0.05))
_LESS_ROUGH = Resolution(400, 96, 0.03)
_BOUNDS = 0.4, 2.5  # of the scale

_Score = Callable[[PreparedSample, SampleStack, Motions, Resolution], FloatArray]


@dataclass(frozen=True, eq=False)
class RoughPose:
    """Rough position of a query on a candidate, found much faster than by `align`.

    Attributes
    ----------
    covered : float
        Share of the surface that may be a part, and lies roughly on the other one, from 0 to 1.
    frame : Frame or None
        From the query to the candidate; None if no position was found.
    """

    covered: float
    frame: Frame | None


def rough_poses(
    query: PreparedSample, candidates: Sequence[SurfaceSample], scales_tried: Sequence[Collection[int]]
) -> list[RoughPose]:
    """Align a query fast and roughly with many candidates, each of which it may be a part of.

    Parameters
    ----------
    query : PreparedSample
    candidates : sequence of SurfaceSample
    scales_tried : sequence of collection of int
        For each candidate, indices of the query's scales to try.

    Returns
    -------
    poses : list of RoughPose
        Those that put the largest share of the query on the candidates, whatever else these have.
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
        if found:
            _choose(poses, group, query, stack, joined(found), scores_of_query)
    return poses


def rough_poses_back(
    query: PreparedSample, candidates: Sequence[SurfaceSample], scales: Sequence[float]
) -> list[RoughPose]:
    """Align many candidates fast and roughly with a query that each may be a part of.

    Parameters
    ----------
    query : PreparedSample
    candidates : sequence of SurfaceSample
    scales : sequence of float
        Sizes of the candidates to try, beside the query.

    Returns
    -------
    poses : list of RoughPose
        Those that put the largest share of each candidate on the query. Independent of each other.
    """
    poses = [RoughPose(0.0, None)] * len(candidates)
    for group in alike(candidates):
        stack = SampleStack.of([candidates[place] for place in group])
        rows = np.arange(len(group))
        motions = [reverse_motions(query, stack, rows, scale, _GROUPS, _KEYPOINTS) for scale in scales]
        _choose(poses, group, query, stack, joined(motions), scores_of_candidates)
    return poses


def _choose(
    poses: list[RoughPose],
    group: Sequence[int],
    query: PreparedSample,
    stack: SampleStack,
    motions: Motions,
    score: _Score,
) -> None:
    """Refine the best motions of each candidate of a group, and keep the best one."""
    motions = motions.within(*_BOUNDS)
    motions, _ = best_motions(motions, score(query, stack, motions, _ROUGH), _REFINED)
    motions = refined_motions(query, stack, motions, _ROUGH_STEPS, _BOUNDS)
    motions, scores = best_motions(motions, score(query, stack, motions, _LESS_ROUGH), 1)
    for position, row in enumerate(motions.rows.tolist()):
        poses[group[row]] = RoughPose(float(scores[position]), motions.frame(position))
