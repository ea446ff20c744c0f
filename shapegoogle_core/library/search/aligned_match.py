# SPDX-License-Identifier: MIT
"""Match with the alignment that verification found, for the stage that explains it."""

from __future__ import annotations

import zlib
from dataclasses import dataclass, fields

from shapegoogle_core.library.match import Match
from shapegoogle_core.registration import Alignment, SurfaceSample

__all__ = ["AlignedMatch", "known_alignment", "sample_key"]


@dataclass(frozen=True, eq=False)
class AlignedMatch(Match):
    """A match whose surface was aligned with the query. It equals the `Match` of the same values.

    Attributes
    ----------
    alignment : Alignment or None
        From the query to the match.
    aligned_sample : int
        `sample_key` of the query's sample.
    """

    alignment: Alignment | None = None
    aligned_sample: int = 0

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Match):
            return NotImplemented
        return all(getattr(self, field.name) == getattr(other, field.name) for field in fields(Match))

    def __hash__(self) -> int:
        return hash(self.rank_key)


def sample_key(sample: SurfaceSample) -> int:
    """Compute a checksum that identifies a sample, the same in every process."""
    return zlib.crc32(sample.points.tobytes())


def known_alignment(match: Match, sample: SurfaceSample) -> Alignment | None:
    """Return the alignment of a sample with a match, if verification has found one.

    Parameters
    ----------
    match : Match
    sample : SurfaceSample
        Of the query.

    Returns
    -------
    alignment : Alignment or None
        None for matches of another query too.
    """
    if isinstance(match, AlignedMatch) and match.aligned_sample == sample_key(sample):
        return match.alignment
    return None
