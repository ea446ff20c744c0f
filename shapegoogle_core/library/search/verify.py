# SPDX-License-Identifier: MIT
"""Geometric verification: the best candidates are laid over the query, and those that fit come first.

Bags say which words a shape has and which of them lie close together. A part cut off or a swollen limb
changes them as much as another shape would; in space the rest still fits to a hair. How exactly it does tells
a part's whole from the relatives of it, which have much in common with it too.

Geometry is asked only where bags are not sure. Of a shape in another pose they know more than it does: it
finds another individual in the query's own pose.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.library.match import DISTANCE_DECIMALS, Match
from shapegoogle_core.library.storage.samples import prepared_matches, stored_supports
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import Alignment, PreparedSample, SurfaceSample, align
from shapegoogle_core.registration.alignment import measure
from shapegoogle_core.registration.exact_fit import RoughPose, fit_exactly, rough_pose
from shapegoogle_core.registration.prepared_sample import SHARED_SCALES

__all__ = ["CERTAIN", "SCREENED", "Examples", "Sharing", "verify"]

SCREENED = 300
"""How many of the best candidates geometry looks at."""

# Where bags alone are so sure of the first match, geometry is not asked: of a shape in another pose they know
# more than it does. 0.7 is the best compromise on the development set, with damaged poses added to it.
CERTAIN = 0.7
# So many are laid over the query at first. If one of them is likely enough, the others are not looked at:
# what stands behind it would have to fit far better in space although its words are far less alike.
_FIRST = 12
_LIKELY = 0.9
# Otherwise so many more of those that bags and their support in space together make the best, by
# d exp(-k support) of the distance d of their bags.
_NEXT, _NEXT_RELATIVES, _SUPPORT_GAIN = 48, 16, 5.0
# The query is laid roughly over all that may share parts with it, then exactly over so many of the best; and
# over so many of the aligned ones that cover most of it.
_EXACT, _EXACT_ALIGNED = 20, 12
# d exp(-k (e - e0)) where a share e > e0 of the query fits exactly. Among creatures, 33 of each kind, it is
# 0.74 or more of three of four halves on their whole, and 0.47 or less on the best of all others.
_EXACT_FROM, _EXACT_GAIN = 0.5, 8.0
# From here on it is no relative: then nothing else is aligned.
_SURELY_EXACT = 0.7


class Examples:
    """Samples of the query, ready to be laid over matches; each match is laid over one of them.

    Parameters
    ----------
    samples : sequence of SurfaceSample
        Of the query; several, if it has several examples.
    nearest : callable
        Which of the samples each of some matches is laid over, by its shape id; the first one, where it is
        not named. With one for each match, several examples take no longer than one.
    """

    def __init__(
        self, samples: Sequence[SurfaceSample], nearest: Callable[[Sequence[Match]], Mapping[int, int]]
    ) -> None:
        self._nearest = nearest
        self._views: dict[int, int] = {}
        self.queries = [_Query(sample) for sample in samples]

    def meet(self, matches: Sequence[Match]) -> None:
        """Choose the sample of each of these matches."""
        if len(self.queries) > 1:
            self._views.update(self._nearest(matches))

    def of(self, match: Match) -> _Query:
        """Return what a match is laid over."""
        return self.queries[self._views.get(match.shape_id, 0)]


class _Query:
    """A sample of the query."""

    def __init__(self, sample: SurfaceSample) -> None:
        self.prepared = PreparedSample(sample)

    @cached_property
    def shared(self) -> PreparedSample:
        """At more scales; only asked for where the first matches are not likely enough."""
        return PreparedSample(self.prepared.sample, SHARED_SCALES)


@dataclass(frozen=True)
class Sharing:
    """Shapes that may share parts with the query.

    Attributes
    ----------
    scales : mapping of int to collection of int
        By their ids, be they among the best by their bags or not: at which of `SHARED_SCALES`.
    relatives : sequence of Match
        Those of them that are not among the best by their bags.
    """

    scales: Mapping[int, Collection[int]]
    relatives: Sequence[Match]


def verify(
    store: Store,
    model: ShapeModel,
    examples: Examples,
    matches: Sequence[Match],
    sharing_parts: Callable[[], Sharing],
) -> list[Match]:
    """Lay the best matches over the query, and lower the distances of those that fit.

    Parameters
    ----------
    store : Store
    model : ShapeModel
    examples : Examples
    matches : sequence of Match
        The best by their bags, best first; at least one.
    sharing_parts : callable
        Finds shapes that may share parts with the query; asked where none of the first matches is likely.

    Returns
    -------
    matches : list of Match
        All of both, best first.
    """
    # Bags where geometry has found nothing say less than bags alone.
    matches = _doubted(model, matches)
    examples.meet(matches)
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        laid = _aligned(examples, prepared_matches(store, model, matches[:_FIRST]))
        _fit_aligned(examples, laid.values())
        rest = list(matches[_FIRST:])
        if max(_verified(model, pair).similarity for pair in laid.values()) < _LIKELY:
            sharing = sharing_parts()
            relatives = _doubted(model, sharing.relatives)
            examples.meet(relatives)
            rest += relatives
            laid |= _looked_for(store, model, examples, [*matches[_FIRST:SCREENED], *relatives], sharing)
            # What the query lies on exactly would come before all that is aligned now.
            if max(pair.exact for pair in laid.values()) < _SURELY_EXACT:
                chosen = _promising(store, model, examples, matches[_FIRST:SCREENED])[:_NEXT]
                # What only words propose is far by its bags, and would have no place among the others.
                chosen += _promising(store, model, examples, relatives)[:_NEXT_RELATIVES]
                aligned = _aligned(examples, prepared_matches(store, model, chosen))
                _fit_aligned(examples, aligned.values())
                laid |= {
                    shape_id: pair
                    for shape_id, pair in aligned.items()
                    if shape_id not in laid
                    or _verified(model, pair).distance <= _verified(model, laid[shape_id]).distance
                }
    verified = [_verified(model, pair) for pair in laid.values()]
    rest = [match for match in rest if match.shape_id not in laid]
    return sorted([*verified, *rest], key=lambda match: match.rank_key)


@dataclass(eq=False)
class _Laid:
    """A match over which the query is laid, where its surface is known; and how much of it fits exactly."""

    match: Match
    prepared: PreparedSample | None
    alignment: Alignment | None
    exact: float = 0.0


def _doubted(model: ShapeModel, matches: Sequence[Match]) -> list[Match]:
    similarities = model.similarity(np.array([match.distance for match in matches]), verified=True)
    return [
        replace(match, similarity=float(similarity))
        for match, similarity in zip(matches, similarities, strict=True)
    ]


def _aligned(examples: Examples, pairs: Iterable[tuple[Match, PreparedSample | None]]) -> dict[int, _Laid]:
    return {
        match.shape_id: _Laid(
            match, prepared, None if prepared is None else align(examples.of(match).prepared, prepared)
        )
        for match, prepared in pairs
    }


def _promising(store: Store, model: ShapeModel, examples: Examples, matches: Sequence[Match]) -> list[Match]:
    """Order matches by their bags and their support in space."""
    promises = []
    for query in examples.queries:
        its = [match for match in matches if examples.of(match) is query]
        scales = range(len(SHARED_SCALES))
        supported = stored_supports(store, model, query.shared, {match.shape_id: scales for match in its})
        for match in its:
            support = float(supported[match.shape_id].max()) if match.shape_id in supported else 0.0
            promises.append((match.distance * math.exp(-_SUPPORT_GAIN * support), match))
    promises.sort(key=lambda pair: (pair[0], pair[1].rank_key))
    return [match for _, match in promises]


def _looked_for(
    store: Store, model: ShapeModel, examples: Examples, matches: Sequence[Match], sharing: Sharing
) -> dict[int, _Laid]:
    """Lay the query roughly over those that may share parts with it; fit it to the best of them."""
    poses: list[tuple[Match, RoughPose]] = []
    sharers = [match for match in matches if match.shape_id in sharing.scales]
    for match, prepared in prepared_matches(store, model, sharers):
        if prepared is not None:
            scales = sorted(sharing.scales[match.shape_id])
            poses.append((match, rough_pose(examples.of(match).shared, prepared, scales)))
    best = sorted(poses, key=lambda pose: (-pose[1].covered, pose[0].rank_key))[:_EXACT]
    laid = {}
    pairs = prepared_matches(store, model, [match for match, _ in best])
    for (match, prepared), (_, pose) in zip(pairs, best, strict=True):
        frame = pose.frame
        if prepared is not None and frame is not None:
            query = examples.of(match).shared
            exact, frame = fit_exactly(query, prepared, frame)
            laid[match.shape_id] = _Laid(match, prepared, measure(query, prepared, frame), exact)
    return laid


def _fit_aligned(examples: Examples, laid: Iterable[_Laid]) -> None:
    """Tell of the aligned matches that cover most of the query how exactly they do."""
    covering = [
        (float(pair.alignment.query_covered.mean()), pair)
        for pair in laid
        if pair.alignment is not None and pair.exact == 0
    ]
    covering.sort(key=lambda scored: (-scored[0], scored[1].match.rank_key))
    for _, pair in covering[:_EXACT_ALIGNED]:
        if pair.prepared is not None and pair.alignment is not None:
            query = examples.of(pair.match).prepared
            pair.exact, _ = fit_exactly(query, pair.prepared, pair.alignment.frame)


def _verified(model: ShapeModel, laid: _Laid) -> Match:
    match = laid.match
    if laid.alignment is None:
        return match
    distance = model.verified_distance(match.distance, laid.alignment.excess)
    distance *= math.exp(-_EXACT_GAIN * max(0.0, laid.exact - _EXACT_FROM))
    distance = round(distance, DISTANCE_DECIMALS)
    return replace(
        match, distance=distance, similarity=float(model.similarity(np.array(distance), verified=True))
    )
