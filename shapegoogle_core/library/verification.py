# SPDX-License-Identifier: MIT
"""Geometric verification: the best candidates are laid over the query, and those that fit come first.

Bags say which words a shape has and which of them lie close together. A part cut off or a swollen limb
changes them as much as another shape would; in space the rest still fits to a hair.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from shapegoogle_core.errors import LibraryError
from shapegoogle_core.library.match import Match
from shapegoogle_core.library.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.registration import Placed, SurfaceSample, align, support

__all__ = ["SCREENED", "verify"]

SCREENED = 300
"""How many of the best candidates geometry looks at."""

# So many are laid over the query at first. If one of them is likely enough, the others are not looked at:
# what stands behind it would have to fit far better in space although its words are far less alike.
_FIRST = 15
_LIKELY = 0.9
# Otherwise so many more: the next by their bags, and those of the rest with the most support in space.
_NEXT, _SUPPORTED = 15, 25


def verify(store: Store, model: ShapeModel, sample: SurfaceSample, matches: Sequence[Match]) -> list[Match]:
    """Lay the best matches over the query, and lower the distances of those that fit.

    Parameters
    ----------
    store : Store
    model : ShapeModel
    sample : SurfaceSample
        Of the query.
    matches : sequence of Match
        Best first.

    Returns
    -------
    matches : list of Match
        All of them, best first.
    """
    query = Placed(sample)
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        first = _candidates(store, matches[:_FIRST])
        verified = [_verified(model, query, *pair) for pair in first]
        rest = list(matches[_FIRST:])
        if rest and max(match.similarity for match in verified) < _LIKELY:
            screened = _candidates(store, rest[:SCREENED])
            order = _by_support(query, screened)
            verified += [_verified(model, query, *screened[position]) for position in order]
            chosen = set(order)
            rest = [match for position, match in enumerate(rest) if position not in chosen]
    return sorted([*verified, *rest], key=lambda match: match.rank_key)


def _by_support(query: Placed, candidates: Sequence[tuple[Match, Placed | None]]) -> list[int]:
    """Positions of the candidates that are worth a closer look."""
    last = range(_NEXT, len(candidates))
    supports = {position: _support(query, candidates[position][1]) for position in last}
    most = sorted(supports, key=lambda position: -supports[position])[:_SUPPORTED]
    return [*range(min(_NEXT, len(candidates))), *most]


def _support(query: Placed, candidate: Placed | None) -> float:
    return 0.0 if candidate is None else support(query, candidate)


def _candidates(store: Store, matches: Sequence[Match]) -> list[tuple[Match, Placed | None]]:
    """Pair matches with their surfaces."""
    samples = store.samples([match.shape_id for match in matches])
    candidates: list[tuple[Match, Placed | None]] = []
    for match in matches:
        data = samples.get(match.shape_id)
        try:
            candidates.append((match, None if data is None else Placed(SurfaceSample.from_bytes(data))))
        except ValueError as error:
            raise LibraryError(
                f"'{store.path}' is damaged: the surface of shape {match.shape_id} ({match.name!r}) cannot "
                f"be read ({error}); index {match.source or 'it'!r} again"
            ) from error
    return candidates


def _verified(model: ShapeModel, query: Placed, match: Match, candidate: Placed | None) -> Match:
    if candidate is None:
        return match
    distance = model.verified_distance(match.distance, align(query, candidate).agreement)
    return replace(match, distance=distance, similarity=float(model.similarity(np.array(distance))))
