# SPDX-License-Identifier: MIT
"""Search for the position in which one of two surfaces lies on the other, as a part lies on its whole.

Most pairs of shapes have nothing in common, so the cheap test comes first: a rough position at a few relative
sizes. Only where it puts enough of one surface on the other, that surface is fitted exactly.
docs/measurements/evidence.md has the shares of parts and of other shapes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from shapegoogle_core.registration.alignment import Alignment
from shapegoogle_core.registration.fit.exact_fit import fit_exactly, rough_pose
from shapegoogle_core.registration.frames import Frame
from shapegoogle_core.registration.prepared_sample import PART_SCALES, PreparedSample
from shapegoogle_core.registration.sample import SurfaceSample

__all__ = ["PartPose", "PartPoses"]

# Share of a surface that lies roughly on the other from which it is fitted.
_ROUGHLY = 0.4
# Share that lies exactly on the other below which a fit is not finished.
_EXACTLY = 0.35
# Share of the query that an alignment puts on the other surface from which it is fitted.
_ALIGNED = 0.5


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
        return self.covered >= _ROUGHLY


class PartPoses:
    """Finds how candidates lie on a query, or the query on them.

    Parameters
    ----------
    sample : SurfaceSample
        Of the query.
    """

    def __init__(self, sample: SurfaceSample) -> None:
        self._sample = sample

    @cached_property
    def _as_part(self) -> PreparedSample:
        return PreparedSample(self._sample, PART_SCALES)

    @cached_property
    def _as_whole(self) -> list[tuple[float, PreparedSample]]:
        """The query enlarged: as a whole of which a candidate of unit area is a part."""
        scales = [1 / scale for scale in PART_SCALES if scale < 1]
        return [(scale, PreparedSample(_enlarged(self._sample, scale), (1.0,))) for scale in scales]

    def find(self, candidate: PreparedSample) -> PartPose:
        """Find the position in which most of one surface lies on the other.

        Parameters
        ----------
        candidate : PreparedSample
            Its first scale is 1.

        Returns
        -------
        pose : PartPose
        """
        forth = rough_pose(self._as_part, candidate)
        found = [PartPose(forth.covered)]
        if forth.frame is not None and found[0].is_promising:
            exact, frame = fit_exactly(self._as_part, candidate, forth.frame, hopeless=_EXACTLY)
            found.append(PartPose(forth.covered, exact, frame=frame.inverse()))
        poses = [(rough_pose(candidate, whole), scale, whole) for scale, whole in self._as_whole]
        back, scale, whole = max(poses, key=lambda pose: pose[0].covered)
        found.append(PartPose(back.covered))
        if back.frame is not None and found[-1].is_promising:
            exact, frame = fit_exactly(candidate, whole, back.frame, hopeless=_EXACTLY)
            frame = Frame(frame.scale / scale, frame.rotation, frame.translation / scale)
            found.append(PartPose(back.covered, exact, of_query=False, frame=frame))
        return max(found, key=lambda pose: (pose.exact, pose.covered))

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
    return replace(
        sample,
        points=scale * sample.points,
        radii=scale * sample.radii,
        descriptors=sample.descriptors_at(scale),
    )
