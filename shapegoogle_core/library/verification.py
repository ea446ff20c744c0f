# SPDX-License-Identifier: MIT
"""Geometric verification: the best candidates are laid over the query, and those that fit come first.

Bags say which words a shape has and which of them lie close together. A part cut off or a swollen limb
changes them as much as another shape would; in space the rest still fits to a hair.

Geometry is asked only where bags are not sure. Of a shape in another pose they know more than it does: it
finds another individual in the query's own pose.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.library.failures import damaged
from shapegoogle_core.library.match import DISTANCE_DECIMALS, Match
from shapegoogle_core.library.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import Placed, SurfaceSample, align, support

__all__ = ["CERTAIN", "SCREENED", "unpack_sample", "verify"]

# The sample that a match is laid over.
QueryOf = Callable[[Match], Placed]

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
_NEXT, _SUPPORT_GAIN = 48, 5.0
# And so many of those that share parts with the query. Counted by themselves: in a library of hundreds they
# are all that is left, and would only take the places of others.
_NEXT_RELATIVES = 16


def verify(
    store: Store,
    model: ShapeModel,
    samples: Sequence[SurfaceSample],
    matches: Sequence[Match],
    relatives: Sequence[Match],
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
        Other shapes that share parts with the query.
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
    placed = [Placed(sample) for sample in samples]

    def query(match: Match) -> Placed:
        return placed[views.get(match.shape_id, 0)]

    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        verified = [_verified(model, query, *pair) for pair in _placed(store, model, matches[:_FIRST])]
        rest = [*matches[_FIRST:], *relatives]
        if rest and max(match.similarity for match in verified) < _LIKELY:
            chosen = _worth_a_look(store, model, query, matches[_FIRST:SCREENED], _NEXT)
            chosen += _worth_a_look(store, model, query, relatives, _NEXT_RELATIVES)
            verified += [_verified(model, query, *pair) for pair in _placed(store, model, chosen)]
            taken = {match.shape_id for match in chosen}
            rest = [match for match in rest if match.shape_id not in taken]
    return sorted([*verified, *rest], key=lambda match: match.rank_key)


def _doubted(model: ShapeModel, matches: Sequence[Match]) -> list[Match]:
    similarities = model.similarity(np.array([match.distance for match in matches]), verified=True)
    return [
        replace(match, similarity=float(similarity))
        for match, similarity in zip(matches, similarities, strict=True)
    ]


def _worth_a_look(
    store: Store, model: ShapeModel, query: QueryOf, candidates: Sequence[Match], count: int
) -> list[Match]:
    """Choose so many of the best by their bags and their support in space."""

    def promise(match: Match, placed: Placed | None) -> float:
        return match.distance * math.exp(
            -_SUPPORT_GAIN * (0.0 if placed is None else support(query(match), placed))
        )

    promises = [(promise(match, placed), match) for match, placed in _placed(store, model, candidates)]
    promises.sort(key=lambda pair: (pair[0], pair[1].rank_key))
    return [match for _, match in promises[:count]]


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


def _verified(model: ShapeModel, query: QueryOf, match: Match, candidate: Placed | None) -> Match:
    if candidate is None:
        return match
    distance = model.verified_distance(match.distance, align(query(match), candidate).excess)
    distance = round(distance, DISTANCE_DECIMALS)
    return replace(
        match, distance=distance, similarity=float(model.similarity(np.array(distance), verified=True))
    )
