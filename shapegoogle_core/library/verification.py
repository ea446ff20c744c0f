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
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.library.failures import damaged
from shapegoogle_core.library.match import DISTANCE_DECIMALS, Match
from shapegoogle_core.library.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import Alignment, Placed, SurfaceSample, align, support
from shapegoogle_core.registration.alignment import SHARED_SCALES, measure
from shapegoogle_core.registration.exactness import RoughPose, exact_fit, rough_pose

__all__ = ["CERTAIN", "SCREENED", "unpack_sample", "verify"]

# What a match is laid over.
QueryOf = Callable[[Match], "_Query"]

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
# Those that may share parts with the query are laid over it roughly, so many of the best then exactly; and
# so many of the aligned ones that cover most of it.
_EXACT, _EXACT_ALIGNED = 20, 12
# d exp(-k (e - e0)) where a share e > e0 of the query fits exactly. Among creatures, 33 of each kind, it is
# 0.74 or more of three of four halves on their whole, and 0.47 or less on the best of all others.
_EXACT_FROM, _EXACT_GAIN = 0.5, 8.0
# From here on it is no relative: then nothing else is aligned.
_SURELY_EXACT = 0.7


def verify(
    store: Store,
    model: ShapeModel,
    samples: Sequence[SurfaceSample],
    matches: Sequence[Match],
    relatives: Sequence[Match],
    sharing: Mapping[int, Collection[int]],
    views: Mapping[int, int],
) -> list[Match]:
    """Lay the best matches over the query, and lower the distances of those that fit.

    Parameters
    ----------
    store : Store
    model : ShapeModel
    samples : sequence of SurfaceSample
        Of the query; several, if it has several examples.
    matches : sequence of Match
        The best by their bags, best first; at least one.
    relatives : sequence of Match
        Other shapes that may share parts with the query.
    sharing : mapping of int to collection of int
        By the ids of all that may, be they among `matches` or not: at which of `SHARED_SCALES`.
    views : mapping of int to int
        Which of the samples a match is laid over, by its shape id; the first one, where it is not named. With
        one for each match, several examples take no longer than one.

    Returns
    -------
    matches : list of Match
        All of both, best first.
    """
    # Bags where geometry has found nothing say less than bags alone.
    matches, relatives = _doubted(model, matches), _doubted(model, relatives)
    queries = [_Query(sample) for sample in samples]

    def query(match: Match) -> _Query:
        return queries[views.get(match.shape_id, 0)]

    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        laid = _aligned(query, _placed(store, model, matches[:_FIRST]))
        _fit_aligned(query, laid.values())
        rest = [*matches[_FIRST:], *relatives]
        if rest and max(_verified(model, pair).similarity for pair in laid.values()) < _LIKELY:
            candidates = [*matches[_FIRST:SCREENED], *relatives]
            known = {match.shape_id for match in matches}
            promises, poses = _looked_at(query, _placed(store, model, candidates), sharing, known)
            laid |= _fitted(query, poses, store, model)
            # What the query lies on exactly would come before all that is aligned now.
            if max(pair.exact for pair in laid.values()) < _SURELY_EXACT:
                chosen = [match for match in promises if match.shape_id in known][:_NEXT]
                # What only words propose is far by its bags, and would have no place among the others.
                chosen += [match for match in promises if match.shape_id not in known][:_NEXT_RELATIVES]
                aligned = _aligned(query, _placed(store, model, chosen))
                _fit_aligned(query, aligned.values())
                laid |= {
                    shape_id: pair
                    for shape_id, pair in aligned.items()
                    if shape_id not in laid
                    or _verified(model, pair).distance <= _verified(model, laid[shape_id]).distance
                }
    verified = [_verified(model, pair) for pair in laid.values()]
    rest = [match for match in rest if match.shape_id not in laid]
    return sorted([*verified, *rest], key=lambda match: match.rank_key)


class _Query:
    """A sample of the query, ready to be laid over matches."""

    def __init__(self, sample: SurfaceSample) -> None:
        self._sample = sample
        self.placed = Placed(sample)

    @cached_property
    def shared(self) -> Placed:
        """At more scales; only asked for where the first matches are not likely enough."""
        return Placed(self._sample, SHARED_SCALES)


@dataclass(eq=False)
class _Laid:
    """A match over which the query is laid, where its surface is known; and how much of it fits exactly."""

    match: Match
    placed: Placed | None
    alignment: Alignment | None
    exact: float = 0.0


def _doubted(model: ShapeModel, matches: Sequence[Match]) -> list[Match]:
    similarities = model.similarity(np.array([match.distance for match in matches]), verified=True)
    return [
        replace(match, similarity=float(similarity))
        for match, similarity in zip(matches, similarities, strict=True)
    ]


def _aligned(query: QueryOf, pairs: Iterable[tuple[Match, Placed | None]]) -> dict[int, _Laid]:
    return {
        match.shape_id: _Laid(match, placed, None if placed is None else align(query(match).placed, placed))
        for match, placed in pairs
    }


def _looked_at(
    query: QueryOf,
    pairs: Iterable[tuple[Match, Placed | None]],
    sharing: Mapping[int, Collection[int]],
    known: Collection[int],
) -> tuple[list[Match], list[tuple[Match, RoughPose]]]:
    """Order matches by their bags and their support in space; lay those roughly that may share parts."""
    promises, poses = [], []
    for match, placed in pairs:
        supported = 0.0
        if placed is not None and match.shape_id in sharing:
            # What only words propose they propose at some sizes; others owe their place to bags.
            among = None if match.shape_id in known else sorted(sharing[match.shape_id])
            pose = rough_pose(query(match).shared, placed, among)
            poses.append((match, pose))
            supported = pose.support
        elif placed is not None:
            supported = support(query(match).placed, placed)
        promises.append((match.distance * math.exp(-_SUPPORT_GAIN * supported), match))
    promises.sort(key=lambda pair: (pair[0], pair[1].rank_key))
    return [match for _, match in promises], poses


def _fitted(
    query: QueryOf, poses: Sequence[tuple[Match, RoughPose]], store: Store, model: ShapeModel
) -> dict[int, _Laid]:
    """Fit the query to the matches on which most of it lies roughly."""
    best = sorted(poses, key=lambda pose: (-pose[1].covered, pose[0].rank_key))[:_EXACT]
    laid = {}
    pairs = _placed(store, model, [match for match, _ in best])
    for (match, placed), (_, pose) in zip(pairs, best, strict=True):
        frame = pose.frame
        if placed is not None and frame is not None:
            exact, frame = exact_fit(query(match).shared, placed, frame)
            alignment = measure(query(match).shared, placed, frame)
            laid[match.shape_id] = _Laid(match, placed, alignment, exact)
    return laid


def _fit_aligned(query: QueryOf, laid: Iterable[_Laid]) -> None:
    """Tell of the aligned matches that cover most of the query how exactly they do."""
    covering = [
        (float(pair.alignment.query_covered.mean()), pair)
        for pair in laid
        if pair.alignment is not None and pair.exact == 0
    ]
    covering.sort(key=lambda scored: (-scored[0], scored[1].match.rank_key))
    for _, pair in covering[:_EXACT_ALIGNED]:
        if pair.placed is not None and pair.alignment is not None:
            pair.exact, _ = exact_fit(query(pair.match).placed, pair.placed, pair.alignment.frame)


def _placed(
    store: Store, model: ShapeModel, matches: Sequence[Match]
) -> Iterator[tuple[Match, Placed | None]]:
    """Pair matches with their surfaces, one at a time: made ready, a surface takes ten times the room."""
    samples = store.samples([match.shape_id for match in matches])
    for match in matches:
        data = samples.get(match.shape_id)
        sample = None if data is None else unpack_sample(store, model, match.shape_id, data)
        yield match, None if sample is None else Placed(sample)


def unpack_sample(store: Store, model: ShapeModel, shape_id: int, data: bytes) -> SurfaceSample:
    """Rebuild a stored sample; `LibraryError` when it is damaged."""
    try:
        sample = SurfaceSample.from_bytes(data)
    except ValueError as error:
        raise damaged(store.path, f"the surface of shape {shape_id} cannot be read: {error}") from error
    settings = model.settings.sample
    if settings is None or (len(sample.points), len(sample.descriptors)) != (
        settings.points,
        settings.keypoints,
    ):
        raise damaged(store.path, f"the surface of shape {shape_id} has another size than its model's")
    return sample


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
