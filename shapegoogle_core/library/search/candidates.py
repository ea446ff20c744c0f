# SPDX-License-Identifier: MIT
"""First stage of a search: candidates by binary codes (algorithm 2 of the paper) and by local words."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.search.codes.code_index import CodeIndex
from shapegoogle_core.library.search.codes.hamming import asymmetric_distances
from shapegoogle_core.library.search.codes.shape_index import StoredIndex
from shapegoogle_core.library.search.codes.view_index import ViewIndex
from shapegoogle_core.library.search.codes.word_index import WordIndex
from shapegoogle_core.library.search.query import Query, QuerySamples
from shapegoogle_core.library.search.settings import CandidateSettings
from shapegoogle_core.library.search.surfaces import Surfaces, candidate_supports, remembered, stored_samples
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.views import CODE_BYTES

__all__ = ["NearestCodes", "NearestViews", "SharedWords"]

ShapeIds = NDArray[np.int64]


class NearestCodes:
    """Candidates with the binary codes nearest to those of the query.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    settings : CandidateSettings

    Attributes
    ----------
    index : StoredIndex
        The codes in memory.
    """

    def __init__(self, store: Store, model: ShapeModel, settings: CandidateSettings) -> None:
        self._store = store
        self._settings = settings
        self._code_bytes = model.code_bits // 8
        self.index = StoredIndex(store, "codes", self._code_bytes, CodeIndex, settings.max_removed)

    def find(self, query: Query, top: int, among: ShapeIds | None = None) -> list[int]:
        """Find the shapes with the codes nearest to one of the examples.

        A bit says on which side of a threshold a projection lies. For the query it is also known how far from
        it: the nearest by Hamming distance are ordered by this distance, see `asymmetric_distances`.

        Parameters
        ----------
        query : Query
        top : int
            Number of matches requested.
        among : (m,) array of int64, optional
            Ids of the shapes to choose from; all shapes by default.

        Returns
        -------
        shape_ids : list of int
            Each once. Some may be of shapes that are gone.
        """
        count = max(self._settings.count, self._settings.per_match * top)
        nearest: list[int] = []
        for code, projection in zip(query.codes, query.projections, strict=True):
            rough = self._nearest(code, self._settings.oversampling * count, among).tolist()
            if len(rough) <= count:  # all are wanted: reading their bags shows which are gone
                nearest += rough
                continue
            shape_ids, known = self._store.codes("codes", rough, self._code_bytes)
            order = np.argsort(asymmetric_distances(known, projection), kind="stable")[:count]
            nearest += shape_ids[order].tolist()
            nearest += set(rough).difference(shape_ids.tolist())  # gone; reading their bags shows it
        return list(dict.fromkeys(nearest))

    def _nearest(self, code: NDArray[np.uint8], count: int, among: ShapeIds | None) -> ShapeIds:
        found = self._store.nearest_codes(code, count, among)
        return self.index.current().nearest(code, count, among) if found is None else found


class NearestViews:
    """Candidates that look like the query: those whose views have the nearest binary codes.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    settings : CandidateSettings

    Attributes
    ----------
    index : StoredIndex or None
        The codes in memory; None for a model without views.
    """

    def __init__(self, store: Store, model: ShapeModel, settings: CandidateSettings) -> None:
        self._settings = settings
        self._views = model.views
        self.index: StoredIndex[ViewIndex] | None = None
        if model.views is not None:
            self.index = StoredIndex(store, "view_codes", CODE_BYTES, ViewIndex, settings.max_removed)

    def find(self, codes: Sequence[NDArray[np.uint8]], top: int, among: ShapeIds | None = None) -> list[int]:
        """Find the shapes that look most like one of the examples, turned and mirrored in any way.

        Parameters
        ----------
        codes : sequence of (64,) array of uint8
            `ShapeSignature.view_code` of the examples that have one.
        top : int
            Number of matches requested.
        among : (m,) array of int64, optional
            Ids of the shapes to choose from; all shapes by default.

        Returns
        -------
        shape_ids : list of int
            Each once, nearest first. Some may be of shapes that are gone.
        """
        if self._views is None or self.index is None or not codes:
            return []
        known = self.index.current()
        count = max(self._settings.count, self._settings.per_match * top)
        nearest = [
            known.nearest(self._views.code_alternatives(code), count, among).tolist() for code in codes
        ]
        return list(dict.fromkeys(shape_id for found in nearest for shape_id in found))


class SharedWords:
    """Candidates that share parts with the query: most local words, and of these the most support in space.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    settings : CandidateSettings

    Attributes
    ----------
    index : StoredIndex or None
        The local words in memory; None for a model without them.
    """

    def __init__(self, store: Store, model: ShapeModel, settings: CandidateSettings) -> None:
        self._settings = settings
        self._words = model.local_words
        self._surfaces: Surfaces = partial(stored_samples, store, model)
        self.index: StoredIndex[WordIndex] | None = None
        if model.settings.local is not None:
            word_bytes = model.settings.local.words // 8
            self.index = StoredIndex(store, "local_words", word_bytes, WordIndex, settings.max_removed)

    def find(self, samples: QuerySamples, among: ShapeIds | None = None) -> dict[int, set[int]]:
        """Find the shapes most supported by the query.

        Parameters
        ----------
        samples : QuerySamples
        among : (m,) array of int64, optional
            Ids of the shapes to choose from; all shapes by default.

        Returns
        -------
        scales : dict of int to set of int
            By shape id: positions of the `SHARED_SCALES` at which the query supports the shape. The best
            first.
        """
        if self._words is None or self.index is None or self._settings.sharing == 0:
            return {}
        words = self.index.current()
        pairs = []
        for example in samples.examples:
            weights = self._words.query_weights(example.prepared.sample)
            ranks: dict[int, dict[int, int]] = {}
            for scale, shape_ids in enumerate(words.nearest(weights, self._settings.sharing, among)):
                for rank, shape_id in enumerate(shape_ids.tolist()):
                    ranks.setdefault(shape_id, {})[scale] = rank
            surfaces = remembered(self._surfaces, samples.surfaces)
            found = candidate_supports(surfaces, example.shared, ranks, finely=self._settings.supported)
            example.supports |= found
            # Removed since their words were read.
            words.discard(set(ranks).difference(found))
            pairs += [
                (-float(found[shape_id][scale]) * self._weight(rank), shape_id, scale)
                for shape_id in found
                for scale, rank in ranks[shape_id].items()
            ]
        scales: dict[int, set[int]] = {}
        for _, shape_id, scale in sorted(pairs)[: self._settings.supported]:
            scales.setdefault(shape_id, set()).add(scale)
        return scales

    def _weight(self, rank: int) -> float:
        return float((1 + rank / self._settings.rank_unit) ** -self._settings.rank_power)
