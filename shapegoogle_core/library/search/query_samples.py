# SPDX-License-Identifier: MIT
"""Surface samples of the query, prepared to be aligned with candidates."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

from shapegoogle_core.library.match import Match
from shapegoogle_core.registration import SHARED_SCALES, PreparedSample, SurfaceSample

__all__ = ["QuerySample", "QuerySamples"]


class QuerySample:
    """A surface sample of one example of the query.

    Parameters
    ----------
    sample : SurfaceSample
    """

    def __init__(self, sample: SurfaceSample) -> None:
        self.prepared = PreparedSample(sample)

    @cached_property
    def shared(self) -> PreparedSample:
        """The sample at more scales, which only searches for shapes with common parts need."""
        return PreparedSample(self.prepared.sample, SHARED_SCALES)


class QuerySamples:
    """Samples of all examples of the query.

    Each match is aligned with one of them, so that several take no longer than one.

    Parameters
    ----------
    samples : sequence of SurfaceSample
    nearest : callable
        Finds the position of the sample that each of some matches is aligned with, by shape id; where it
        names none, the first one is used. Called only if there are several samples.
    """

    def __init__(
        self, samples: Sequence[SurfaceSample], nearest: Callable[[Sequence[Match]], Mapping[int, int]]
    ) -> None:
        self.examples = [QuerySample(sample) for sample in samples]
        self._nearest = nearest
        self._chosen: dict[int, int] = {}

    def choose(self, matches: Sequence[Match]) -> None:
        """Choose the sample for each of these matches."""
        if len(self.examples) > 1:
            self._chosen.update(self._nearest(matches))

    def of(self, match: Match) -> QuerySample:
        """Return the sample that a match is aligned with."""
        return self.examples[self._chosen.get(match.shape_id, 0)]
