# SPDX-License-Identifier: MIT
"""One list for two questions: the same shape comes first, then shapes of the same kind.

The stages before find and verify shapes by their bags. Here shapes that look like the query join them, and
all are ordered by bags, views and simple measures together; see `shapegoogle_core.model.ranking`. Several
examples and negative ones count as in `shapegoogle_core.library.search.query`: the geometric mean of kind
distances, raised by the odds that a shape is of the kind of a negative example.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.match import DISTANCE_DECIMALS, Match, ranked, typical_distances
from shapegoogle_core.library.search.candidates import NearestViews
from shapegoogle_core.library.search.query import FARTHEST, Query, pool_distances
from shapegoogle_core.library.search.rerank import Reranker
from shapegoogle_core.library.search.settings import Rank, SearchSettings
from shapegoogle_core.library.search.traits.distances import Traits
from shapegoogle_core.library.search.traits.stored import StoredTraits
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.ranking import Ranking
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["Fusion", "list_distances"]

# Shapes whose traits are in memory at once.
_AT_ONCE = 1_000


class Fusion:
    """Orders matches by shape and kind.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes. Without a ranking and a background, matches stay as they are.
    settings : SearchSettings
    views : NearestViews
        Candidates by their views.
    reranker : Reranker
        Compares their bags.
    traits : StoredTraits or None
        None for a model without them.
    """

    def __init__(
        self,
        store: Store,
        model: ShapeModel,
        settings: SearchSettings,
        views: NearestViews,
        reranker: Reranker,
        traits: StoredTraits | None,
    ) -> None:
        self._store, self._model = store, model
        self._pairs = traits
        self._views = views
        self._reranker = reranker
        self._unlike_weight = settings.rerank.unlike_weight

    def with_likeness(self, like: Sequence[ShapeSignature], matches: Sequence[Match]) -> list[Match]:
        """Give matches their likeness, and keep their order.

        Parameters
        ----------
        like : sequence of ShapeSignature
            Examples of the query.
        matches : sequence of Match

        Returns
        -------
        matches : list of Match
        """
        ranking = self._model.ranking
        if self._pairs is None or ranking is None or not matches:
            return list(matches)
        kind = self._kind_distances(self._pairs.of(like), [match.shape_id for match in matches])
        return [
            replace(match, likeness=float(ranking.likeness(kind[match.shape_id])))
            if match.shape_id in kind
            else match
            for match in matches
        ]

    def order(
        self,
        query: Query,
        like: Sequence[ShapeSignature],
        unlike: Sequence[ShapeSignature],
        matches: Sequence[Match],
        count: int,
        among: NDArray[np.int64] | None,
        *,
        rank: Rank,
        exact: bool,
    ) -> list[Match]:
        """Let shapes that look like the query join the matches, and order all.

        Parameters
        ----------
        query : Query
        like, unlike : sequence of ShapeSignature
            Its examples, and negative ones.
        matches : sequence of Match
            From the stages before, best first.
        count : int
            Number of matches requested.
        among : (m,) array of int64 or None
            Ids of the shapes to search; None for all.
        rank : {"shape", "kind", "both"}
        exact : bool
            Compare all shapes, and not only those with near codes.

        Returns
        -------
        matches : list of Match
            Best first; for "shape" and without a ranking they are as before.
        """
        ranking = self._model.ranking
        if self._pairs is None or ranking is None or rank == "shape":
            return list(matches)
        own, others = self._pairs.of(like), self._pairs.of(unlike) if unlike else None
        joined = [*matches, *self._joining(query, like, own, matches, count, among, exact=exact)]
        kind = self._kind_distances(own, [match.shape_id for match in joined])
        joined = [match for match in joined if match.shape_id in kind]
        if not joined:
            return []
        distances = np.array([kind[match.shape_id] for match in joined])
        likeness = ranking.likeness(distances)
        if others is not None:
            distances = self._raised(distances, others, joined)
        if rank == "both":
            distances = list_distances(self._model, ranking, distances, joined)
        distances = np.round(np.minimum(distances, FARTHEST), DISTANCE_DECIMALS)
        ordered = [
            ranked(match, distance, alike)
            for match, distance, alike in zip(joined, distances.tolist(), likeness.tolist(), strict=True)
        ]
        return sorted(ordered, key=lambda match: match.rank_key)

    def _joining(
        self,
        query: Query,
        like: Sequence[ShapeSignature],
        own: Traits,
        matches: Sequence[Match],
        count: int,
        among: NDArray[np.int64] | None,
        *,
        exact: bool,
    ) -> list[Match]:
        """Find further shapes that look like the query, and compare their bags."""
        if exact:
            found = self._nearest_of_all(own, count, among)
        else:
            codes = [signature.view_code for signature in like if signature.view_code is not None]
            found = self._views.find(codes, count, among)
        known = {match.shape_id for match in matches}
        further = [shape_id for shape_id in found if shape_id not in known]
        if not further:
            return []
        joining, gone = self._reranker.rank(query, further, len(further))
        if gone and self._views.index is not None:
            self._views.index.discard(gone)
        if not any(match.alignment is not None for match in matches):
            return joining
        # Where geometry has found nothing, the same bags are a weaker sign than without verification.
        similarities = self._model.similarity(
            [match.distance for match in joining], typical_distances(joining), verified=True
        )
        return [
            replace(match, similarity=float(similarity))
            for match, similarity in zip(joining, similarities, strict=True)
        ]

    def _nearest_of_all(self, own: Traits, count: int, among: NDArray[np.int64] | None) -> list[int]:
        """Find the shapes with the least kind distances."""
        best: list[tuple[float, int]] = []
        for shape_ids in self._portions(among):
            kind = self._kind_distances(own, shape_ids)
            best = sorted([*best, *((distance, shape_id) for shape_id, distance in kind.items())])[:count]
        return [shape_id for _, shape_id in best]

    def _portions(self, among: NDArray[np.int64] | None) -> list[list[int]]:
        if among is None:
            with self._store.snapshot():
                listed: list[int] = []
                while records := self._store.shapes_after(listed[-1] if listed else 0, _AT_ONCE):
                    listed += [record.shape_id for record in records]
        else:
            listed = among.tolist()
        return [listed[start : start + _AT_ONCE] for start in range(0, len(listed), _AT_ONCE)]

    def _kind_distances(self, own: Traits, shape_ids: Sequence[int]) -> dict[int, float]:
        """Kind distances of the query from shapes, without those that are gone."""
        assert self._pairs is not None
        found: dict[int, float] = {}
        for start in range(0, len(shape_ids), _AT_ONCE):
            traits = self._pairs.read(shape_ids[start : start + _AT_ONCE])
            each = [self._pairs.kind_distances(own, row, traits) for row in range(len(own.ids))]
            found |= zip(traits.ids.tolist(), pool_distances(np.stack(each)).tolist(), strict=True)
        return found

    def _raised(self, distances: FloatArray, unlike: Traits, matches: Sequence[Match]) -> FloatArray:
        """Raise distances of shapes that are of the kind of a negative example."""
        ranking = self._model.ranking
        assert self._pairs is not None
        assert ranking is not None
        nearest: dict[int, float] = {}
        ids = [match.shape_id for match in matches]
        for start in range(0, len(ids), _AT_ONCE):
            traits = self._pairs.read(ids[start : start + _AT_ONCE])
            each = [self._pairs.kind_distances(unlike, row, traits) for row in range(len(unlike.ids))]
            nearest |= zip(traits.ids.tolist(), np.min(each, axis=0).tolist(), strict=True)
        likeness = ranking.likeness([nearest.get(shape_id, np.inf) for shape_id in ids])
        copies = likeness == 1
        odds = likeness / np.where(copies, 1, 1 - likeness)
        raised = distances * (1 + self._unlike_weight * odds) ** (1 / ranking.likeness_slope)
        raised[copies] = np.inf
        return np.asarray(raised, np.float64)


def list_distances(
    model: ShapeModel, ranking: Ranking, kind: FloatArray, matches: Sequence[Match]
) -> FloatArray:
    """Compute the distances that a list of both, the same shape and the same kind, is sorted by.

    Parameters
    ----------
    model : ShapeModel
        With a background.
    ranking : Ranking
        Of the model.
    kind : (n,) array
        Kind distances of the matches.
    matches : sequence of n Match
        Verified or not, with the distances of their bags.

    Returns
    -------
    distances : (n,) array
    """
    typical = typical_distances(matches)
    assert typical is not None  # the model has a background
    bags = [match.distance if match.bag_distance is None else match.bag_distance for match in matches]
    verified = [min(match.distance, own) for match, own in zip(matches, bags, strict=True)]
    # What is missing of a part changes its bags more than its local heat.
    whole = [
        own if match.bent_distance is None else min(own, match.bent_distance)
        for match, own in zip(matches, bags, strict=True)
    ]
    return ranking.verified_distances(
        ranking.sorting_distances(kind, whole, typical),
        model.similarity(bags, typical, verified=True),
        model.similarity(verified, typical, verified=True),
    )
