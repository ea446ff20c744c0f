# SPDX-License-Identifier: MIT
"""The order of the stages of a search: candidates, re-ranking, verification.

Candidates are the shapes with the nearest binary codes (algorithm 2 of the paper); their full bags are
compared; the best are aligned with the query. Where bags are uncertain, shapes that share parts with the
query are candidates too. The fourth stage, evidence, follows on request.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.match import Match, typical_distances
from shapegoogle_core.library.neighbours.candidates import StoredCandidates
from shapegoogle_core.library.neighbours.graph import NeighbourGraph
from shapegoogle_core.library.neighbours.pairs import BagPairs, TraitPairs
from shapegoogle_core.library.search.candidates import NearestCodes, NearestViews, SharedWords
from shapegoogle_core.library.search.codes.shape_index import StoredIndex
from shapegoogle_core.library.search.prepared import PreparedQueries
from shapegoogle_core.library.search.query import FARTHEST, Query, QuerySamples
from shapegoogle_core.library.search.rerank import Reranker
from shapegoogle_core.library.search.settings import SearchSettings
from shapegoogle_core.library.search.stages import CANDIDATE_STAGES, OWN_STAGE, CandidateStage, chosen
from shapegoogle_core.library.search.surfaces import stored_samples
from shapegoogle_core.library.search.traits.stored import StoredBags, StoredTraits
from shapegoogle_core.library.search.verify import Sharing, Verifier
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel

__all__ = ["Search"]

ShapeIds = NDArray[np.int64]


class Search:
    """Search in a library. Keeps all codes in memory from the first search on, and reads only new ones.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    settings : SearchSettings

    Attributes
    ----------
    nearest_views : NearestViews
        Candidates by their views; its codes are in memory once.
    reranker : Reranker
        Second stage.
    traits : StoredTraits or None
        Traits of the shapes; None for a model that orders by shape only.
    prepared : PreparedQueries
        The latest queries.
    """

    def __init__(self, store: Store, model: ShapeModel, settings: SearchSettings) -> None:
        self._store = store
        self._model = model
        self._settings = settings
        self._nearest_codes = NearestCodes(store, model, settings.candidates)
        self._stages: list[CandidateStage] = [
            # The neighbour graph shares the codes in memory.
            self._nearest_codes
            if name == OWN_STAGE
            else chosen(CANDIDATE_STAGES, name)(store, model, settings.candidates)
            for name in settings.candidates.stages
        ]
        self.nearest_views = NearestViews(store, model, settings.candidates)
        self._shared_words = SharedWords(store, model, settings.candidates)
        self._bags = StoredBags(store, model)
        self.traits = StoredTraits(store, model, self._bags) if StoredTraits.possible(model) else None
        self.reranker = Reranker(store, model, settings.rerank, self._bags)
        self.prepared = PreparedQueries(settings.evidence)
        self._verifier = Verifier(partial(stored_samples, store, model), model, settings.verification)

    def neighbour_graph(self) -> NeighbourGraph:
        """Make the neighbour graph of the library, which shares the codes in memory."""
        return NeighbourGraph(
            self._store,
            StoredCandidates(self._store, self._model, self._nearest_codes.index, self.nearest_views.index),
            BagPairs(self._model, self._bags) if self.traits is None else TraitPairs(self.traits),
            self._settings.walk,
            self._model.code_bits // 8,
        )

    def among_nearest_codes(self, query: Query, top: int, among: ShapeIds | None = None) -> list[Match]:
        """Compare the full bags of the shapes with the nearest codes, and verify the best.

        Parameters
        ----------
        query : Query
        top : int
            Number of matches requested.
        among : (m,) array of int64, optional
            Ids of the shapes to search; all by default.

        Returns
        -------
        matches : list of Match
            Best first: at least the min(top, shapes) best.
        """
        find = partial(self._candidates, query, top, among)
        # In one snapshot: a candidate must not vanish between its code and its bags.
        with self._store.snapshot():
            best = self._ranked(self._nearest_codes.index, find, query, self._kept(query, top))
        return self._verified(query, best, among)

    def among_all(self, query: Query, top: int, among: ShapeIds | None = None) -> list[Match]:
        """Compare the full bags of all shapes; otherwise like `among_nearest_codes`."""
        while True:
            best = self.reranker.rank_all(query, self._kept(query, top), among)
            if len(self._store.shapes([match.shape_id for match in best])) == len(best):
                return self._verified(query, best, among)
            # A writer removed one of the best meanwhile; the shape that it displaced must come in, so start
            # again.

    def among_more(
        self, query: Query, count: int, best: Sequence[Match], among: ShapeIds | None = None, *, exact: bool
    ) -> list[Match]:
        """Return more matches of a search, compared by their bags only.

        Parameters
        ----------
        query : Query
        count : int
            Number of matches.
        best : sequence of Match
            From `among_nearest_codes` or `among_all`. They have been verified, and come first.
        among : (m,) array of int64, optional
            As before.
        exact : bool
            Whether `best` is from `among_all`.

        Returns
        -------
        matches : list of Match
            Best first: `best`, and the others after it.
        """
        if exact:
            ranked = self.reranker.rank_all(query, count, among)
        else:
            find = partial(self._candidates, query, count, among)
            with self._store.snapshot():
                ranked = self._ranked(self._nearest_codes.index, find, query, count)
        known = {match.shape_id for match in best}
        others = [match for match in ranked if match.shape_id not in known]
        if others and any(match.alignment is not None for match in best):
            # Where geometry has found nothing, the same bags are a weaker sign than without verification.
            similarities = self._model.similarity(
                [match.distance for match in others], typical_distances(others), verified=True
            )
            others = [
                replace(match, similarity=float(similarity))
                for match, similarity in zip(others, similarities, strict=True)
            ]
        return [*best, *(replace(match, distance=min(match.distance, FARTHEST)) for match in others)]

    def _candidates(self, query: Query, top: int, among: ShapeIds | None) -> list[int]:
        """Find the candidates of all stages, each once."""
        found = [stage.find(query, top, among) for stage in self._stages]
        return list(dict.fromkeys(shape_id for shape_ids in found for shape_id in shape_ids))

    def _kept(self, query: Query, top: int) -> int:
        """Return the number of matches to keep by their bags: any of them may come first in the end."""
        return max(top, self._settings.verification.candidates) if query.sampled else top

    def _ranked(
        self, index: StoredIndex[Any], find: Callable[[], Sequence[int]], query: Query, count: int
    ) -> list[Match]:
        """Compare the bags of the shapes that are found in an index of codes."""
        for _ in range(2):
            matches, gone = self.reranker.rank(query, find(), count)
            if not gone:
                return matches
            # Removed since their codes were read; other shapes take their places.
            index.discard(gone)
        # More were removed than just these, so read all codes again.
        index.forget()
        return self.reranker.rank(query, find(), count)[0]

    def _verified(self, query: Query, matches: list[Match], among: ShapeIds | None) -> list[Match]:
        if query.sampled:
            # That a copy of one of several examples is certain says nothing about the others.
            copies = [match for match in matches if query.several and match.distance == 0]
            rest = matches[len(copies) :]
            own = [self.prepared.of(signature).prepared for signature in query.sampled]
            cut = any(prepared.sample.is_cut for prepared in own)
            if rest and self._verifier.is_needed(rest[0], several=query.several, cut=cut):
                known = {match.shape_id for match in matches}
                samples = QuerySamples(own, partial(self.reranker.nearest_samples, query))
                find_sharing = partial(self._sharing, query, samples, known, among)
                rest = self._verifier.verify(samples, rest, find_sharing)
            matches = [*copies, *rest]
        if not query.has_unlike:
            return matches
        # In order by now: the very last ones are farther than a distance can be.
        return [replace(match, distance=min(match.distance, FARTHEST)) for match in matches]

    def _sharing(
        self, query: Query, samples: QuerySamples, known: set[int], among: ShapeIds | None
    ) -> Sharing:
        """Find the shapes that share parts with the query, and compare the bags of those not yet compared."""
        index = self._shared_words.index
        if index is None:
            return Sharing({}, [])
        scales: dict[int, set[int]] = {}

        def unknown() -> list[int]:
            scales.clear()
            scales.update(self._shared_words.find(samples, among))
            return [shape_id for shape_id in scales if shape_id not in known]

        with self._store.snapshot():
            relatives = self._ranked(index, unknown, query, self._settings.candidates.supported)
        return Sharing(scales, relatives)
