# SPDX-License-Identifier: MIT
"""Second stage of a search: re-ranking of candidates by their full bags."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.match import Match
from shapegoogle_core.library.search.query import Query
from shapegoogle_core.library.search.settings import RerankSettings
from shapegoogle_core.library.search.traits.stored import StoredBags
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["Reranker"]


class Reranker:
    """Compares full bags.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    settings : RerankSettings
    bags : StoredBags
        Of the library.
    """

    def __init__(self, store: Store, model: ShapeModel, settings: RerankSettings, bags: StoredBags) -> None:
        self._store = store
        self._model = model
        self._bags = bags
        self._at_once = max(1, settings.entries_at_once // model.bag_size)

    def rank(self, query: Query, candidates: Sequence[int], count: int) -> tuple[list[Match], set[int]]:
        """Compare candidates with the query.

        Parameters
        ----------
        query : Query
        candidates : sequence of int
            Ids of shapes, each once.
        count : int
            Number of matches to keep.

        Returns
        -------
        matches : list of Match
            Best first.
        gone : set of int
            Ids of candidates that were removed from the library meanwhile.
        """
        best: list[Match] = []
        gone: set[int] = set()
        for start in range(0, len(candidates), self._at_once):
            portion = candidates[start : start + self._at_once]
            # What is in memory may be of shapes that are gone.
            there, _ = self._store.codes("codes", portion, self._model.code_bits // 8)
            shape_ids, vectors, background = self._bags.read(there.tolist())
            gone |= set(portion).difference(shape_ids.tolist())
            best = self._merge(best, query, shape_ids.tolist(), vectors, background, count)
        return best, gone

    def rank_all(self, query: Query, count: int, among: NDArray[np.int64] | None = None) -> list[Match]:
        """Compare all shapes with the query.

        Parameters
        ----------
        query : Query
        count : int
            Number of matches to keep.
        among : (m,) array of int64, optional
            Ids of the shapes to compare; all shapes by default.

        Returns
        -------
        matches : list of Match
            Best first.
        """
        best: list[Match] = []
        for shape_ids, bags in self._portions(among):
            best = self._merge(best, query, shape_ids, self._model.comparable(bags), None, count)
        return best

    def nearest_samples(self, query: Query, matches: Sequence[Match]) -> dict[int, int]:
        """Find the sample of the query that each match is nearest to by its bags, by shape id."""
        shape_ids, vectors, _ = self._bags.read([match.shape_id for match in matches])
        return dict(zip(shape_ids.tolist(), query.nearest_samples(vectors).tolist(), strict=True))

    def _portions(self, among: NDArray[np.int64] | None) -> Iterator[tuple[list[int], NDArray[np.float32]]]:
        """Read all bags, in one snapshot for each portion: no writer waits until all are compared."""
        if among is not None:
            for start in range(0, len(among), self._at_once):
                with self._store.snapshot():
                    portion = among[start : start + self._at_once].tolist()
                    yield self._store.bags(portion, self._model.bag_size)
            return
        last_id = 0
        while True:
            with self._store.snapshot():
                shape_ids, bags = self._store.bags_after(last_id, self._at_once, self._model.bag_size)
                if not shape_ids:
                    return
                yield shape_ids, bags
            last_id = shape_ids[-1]

    def _merge(
        self,
        best: list[Match],
        query: Query,
        shape_ids: list[int],
        vectors: FloatBags,
        background: FloatArray | None,
        count: int,
    ) -> list[Match]:
        """Compare a portion of the library, in the order of ids, and keep the `count` best so far."""
        distances = query.distances(vectors)
        if len(distances) > count:
            # Equals of the last one are kept: their names decide, and names are read only for these few.
            chosen = np.flatnonzero(distances <= np.partition(distances, count - 1)[count - 1])
        else:
            chosen = np.arange(len(distances))
        records = self._store.shapes([shape_ids[position] for position in chosen])
        typical = query.typical_distances(
            self._background(vectors[chosen]) if background is None else background[chosen]
        )
        similarities = self._model.similarity(distances[chosen], typical)
        matches = [
            Match(
                name=record.name,
                source=record.source,
                object_name=record.object_name,
                distance=float(distance),
                bag_distance=float(distance),
                typical_distance=None if typical is None else float(typical[number]),
                similarity=float(similarity),
                shape_id=record.shape_id,
                vertex_count=record.vertex_count,
                face_count=record.face_count,
                area=record.area,
                placement_count=record.placement_count,
                tags=record.tags,
                origin=record.origin,
            )
            for number, (record, distance, similarity) in enumerate(
                zip(records, distances[chosen], similarities, strict=True)
            )
        ]
        return heapq.nsmallest(count, [*best, *matches], key=lambda match: match.rank_key)

    def _background(self, vectors: FloatBags) -> FloatArray | None:
        background = self._model.background
        return None if background is None else background.distances(self._model.settings.metric, vectors)
