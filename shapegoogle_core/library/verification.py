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
from shapegoogle_core.registration import Placed, SurfaceSample, align

__all__ = ["VERIFIED", "verify"]

VERIFIED = 60
"""How many of the best candidates are laid over the query at most."""

# So many of them at once. If one of them is likely enough, the others are not looked at: what is behind it
# would have to fit far better in space although its words are far less alike.
_AT_ONCE = 15
_LIKELY = 0.9


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
    verified: list[Match] = []
    # On matrices of this size a second BLAS thread only doubles the processor time.
    with threadpool_limits(1, user_api="blas"):
        for start in range(0, min(len(matches), VERIFIED), _AT_ONCE):
            portion = matches[start : min(start + _AT_ONCE, VERIFIED)]
            samples = store.samples([match.shape_id for match in portion])
            for match in portion:
                verified.append(_verified(store, model, query, samples.get(match.shape_id), match))
            if max(match.similarity for match in verified) >= _LIKELY:
                break
    return sorted([*verified, *matches[len(verified) :]], key=lambda match: match.rank_key)


def _verified(store: Store, model: ShapeModel, query: Placed, data: bytes | None, match: Match) -> Match:
    if data is None:
        return match
    try:
        candidate = Placed(SurfaceSample.from_bytes(data))
    except ValueError as error:
        raise LibraryError(
            f"'{store.path}' is damaged: the surface of shape {match.shape_id} ({match.name!r}) cannot be "
            f"read ({error}); index {match.source or 'it'!r} again"
        ) from error
    distance = model.verified_distance(match.distance, align(query, candidate).agreement)
    return replace(match, distance=distance, similarity=float(model.similarity(np.array(distance))))
