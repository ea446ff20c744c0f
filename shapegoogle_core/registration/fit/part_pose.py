# SPDX-License-Identifier: MIT
"""Search for the position in which one of two surfaces lies on the other, as a part lies on its whole.

Most pairs of shapes have nothing in common, so the cheap test comes first: a rough position at a few relative
sizes, of many candidates at once. Only where it puts enough of one surface on the other, that surface is
fitted exactly. docs/measurements/evidence.md has the shares of parts and of other shapes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from shapegoogle_core.registration.alignment import Alignment
from shapegoogle_core.registration.fit.exact_fit import fit_exactly
from shapegoogle_core.registration.fit.rough_pose import RoughPose, rough_poses, rough_poses_back
from shapegoogle_core.registration.frames import Frame
from shapegoogle_core.registration.prepared_sample import PART_SCALES, PreparedSample
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["PartPose", "PartPoses"]

# Share of the query, and of the candidate, that lies roughly on the other surface from which it is fitted.
_ROUGHLY, _ROUGHLY_BACK = 0.45, 0.27
# Share that lies exactly on the other below which a fit is not finished.
_EXACTLY = 0.35
# Share of the query that an alignment puts on the other surface from which it is fitted.
_ALIGNED = 0.5
# Sizes of candidates that are parts of the query, beside it.
_SMALLER = (0.85, 0.7, 0.6)


@dataclass(frozen=True, eq=False)
class PartPose:
    """Position of a candidate on a query.

    Attributes
    ----------
    covered : float
        Share of one of the two surfaces that lies roughly on the other, from 0 to 1.
    exact : float
        Share of one of them that lies exactly on the other, see `fit_exactly`; 0 without a frame.
    of_query : bool
        Whether it is the query that lies on the candidate.
    frame : Frame or None
        From the candidate to the query; None if in no position that was tried enough lies roughly on it.
    """

    covered: float
    exact: float = 0.0
    of_query: bool = True
    frame: Frame | None = None

    @property
    def is_promising(self) -> bool:
        """Whether enough of one surface lies roughly on the other for a closer look."""
        return self.covered >= (_ROUGHLY if self.of_query else _ROUGHLY_BACK)


class PartPoses:
    """Finds how candidates lie on a query, or the query on them.

    Parameters
    ----------
    prepared : PreparedSample
        Of the query.
    """

    def __init__(self, prepared: PreparedSample) -> None:
        self._prepared = prepared

    @cached_property
    def _as_part(self) -> PreparedSample:
        return self._prepared.at_other_scales(PART_SCALES)

    @cached_property
    def _as_whole(self) -> list[tuple[float, PreparedSample]]:
        """The query enlarged: as a whole of which a candidate of unit area is a part."""
        scales = [1 / scale for scale in _SMALLER]
        return [(scale, PreparedSample(_enlarged(self._prepared.sample, scale), (1.0,))) for scale in scales]

    def find(self, candidates: Sequence[PreparedSample]) -> list[PartPose]:
        """Find the positions in which most of one surface lies on the other.

        Parameters
        ----------
        candidates : sequence of PreparedSample

        Returns
        -------
        poses : list of PartPose
            Independent of each other.
        """
        samples = [candidate.sample for candidate in candidates]
        forth = rough_poses(self._as_part, samples, [range(len(PART_SCALES))] * len(samples))
        back = rough_poses_back(self._as_part, samples, _SMALLER)
        return [
            max(self._fitted(*three), key=lambda pose: (pose.exact, pose.covered))
            for three in zip(candidates, forth, back, strict=True)
        ]

    def _fitted(self, candidate: PreparedSample, forth: RoughPose, back: RoughPose) -> list[PartPose]:
        found = [PartPose(forth.covered), PartPose(back.covered, of_query=False)]
        if forth.frame is not None and found[0].is_promising:
            exact, frame = fit_exactly(self._as_part, candidate, forth.frame, hopeless=_EXACTLY)
            found.append(PartPose(forth.covered, exact, frame=frame.inverse()))
        if back.frame is not None and found[1].is_promising:
            size = back.frame.scale
            scale, whole = min(self._as_whole, key=lambda pair: abs(pair[0] - size))
            start = back.frame.inverse()
            start = Frame(start.scale * scale, start.rotation, start.translation * scale)
            exact, frame = fit_exactly(candidate, whole, start, hopeless=_EXACTLY)
            frame = Frame(frame.scale / scale, frame.rotation, frame.translation / scale)
            found.append(PartPose(back.covered, exact, of_query=False, frame=frame))
        return found

    def refine(self, candidate: PreparedSample, pose: PartPose, alignment: Alignment) -> PartPose:
        """Try the position of an alignment too.

        Parameters
        ----------
        candidate : PreparedSample
        pose : PartPose
            From `find`.
        alignment : Alignment
            From the query to the candidate.

        Returns
        -------
        pose : PartPose
            The better one of both.
        """
        if alignment.query_covered[-1] < _ALIGNED:
            return pose
        exact, frame = fit_exactly(self._as_part, candidate, alignment.frame, hopeless=_EXACTLY)
        covered = max(pose.covered, float(alignment.query_covered[-1]))
        return pose if exact <= pose.exact else PartPose(covered, exact, frame=frame.inverse())


def _enlarged(sample: SurfaceSample, scale: float) -> SurfaceSample:
    """Enlarge the surface for an exact fit, which needs no descriptors."""
    return replace(sample, points=scale * sample.points, radii=scale * sample.radii)
