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
# Share of the query that an alignment puts on the other surface from which it is fitted.
_ALIGNED = 0.5


@dataclass(frozen=True, eq=False)
class PartPose:
    """Position of a candidate on a query.

    Attributes
    ----------
    frame : Frame
        From the candidate to the query.
    exact : float
        Share of one of the two surfaces that lies exactly on the other, see `fit_exactly`.
    """

    frame: Frame
    exact: float


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

    def find(self, candidate: SurfaceSample, alignment: Alignment | None = None) -> PartPose | None:
        """Find the position in which most of one surface lies exactly on the other.

        Parameters
        ----------
        candidate : SurfaceSample
        alignment : Alignment, optional
            From the query to the candidate, if one is known.

        Returns
        -------
        pose : PartPose or None
            None if in no position that was tried enough lies roughly on the other.
        """
        prepared = PreparedSample(candidate, (1.0,))
        found: list[PartPose] = []
        if alignment is not None and alignment.query_covered[-1] >= _ALIGNED:
            exact, frame = fit_exactly(self._as_part, prepared, alignment.frame)
            found.append(PartPose(frame.inverse(), exact))
        forth = rough_pose(self._as_part, prepared)
        if forth.frame is not None and forth.covered >= _ROUGHLY:
            exact, frame = fit_exactly(self._as_part, prepared, forth.frame)
            found.append(PartPose(frame.inverse(), exact))
        poses = [(rough_pose(prepared, whole), scale, whole) for scale, whole in self._as_whole]
        back, scale, whole = max(poses, key=lambda pose: pose[0].covered)
        if back.frame is not None and back.covered >= _ROUGHLY:
            exact, frame = fit_exactly(prepared, whole, back.frame)
            found.append(
                PartPose(Frame(frame.scale / scale, frame.rotation, frame.translation / scale), exact)
            )
        return max(found, key=lambda pose: pose.exact, default=None)


def _enlarged(sample: SurfaceSample, scale: float) -> SurfaceSample:
    return replace(
        sample,
        points=scale * sample.points,
        radii=scale * sample.radii,
        descriptors=sample.descriptors_at(scale),
    )
