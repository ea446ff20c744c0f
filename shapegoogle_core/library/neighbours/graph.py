# SPDX-License-Identifier: MIT
"""The neighbour graph of a library: kept up to date as shapes come, and walked around a query.

The graph is only ever less complete than it could be, never wrong: a shape without neighbours, because a run
was interrupted or an older program added it, is ordered by its distance; a neighbour that was removed is
passed over; and what one of two writers has written last counts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapegoogle_core.library.neighbours.pairs import PairDistances
from shapegoogle_core.library.neighbours.walk import (
    COPY_DISTANCE,
    link_weights,
    links_of,
    links_of_all,
    visits,
    walked_distances,
)
from shapegoogle_core.library.search.settings import WalkSettings
from shapegoogle_core.library.storage.store import Neighbours, Store, all_codes
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["FindCandidates", "NeighbourGraph"]

FindCandidates = Callable[[int], Sequence[int]]
"""Finds the ids of shapes whose codes are near to those of a shape; itself may be one of them."""

# Neighbours that are stored besides those the walk uses: some will be removed.
_SPARE = 4
# Shapes without neighbours that are read at once.
_PAGE = 256


class NeighbourGraph:
    """The nearest shapes of each shape of a library.

    Parameters
    ----------
    store : Store
    find : callable
        Candidates for the neighbours of a stored shape.
    pairs : PairDistances
    settings : WalkSettings
    code_bytes : int
        Length of the codes of the library's model.
    """

    def __init__(
        self,
        store: Store,
        find: FindCandidates,
        pairs: PairDistances,
        settings: WalkSettings,
        code_bytes: int,
    ) -> None:
        self._store = store
        self._code_bytes = code_bytes
        self._find = find
        self._pairs = pairs
        self._settings = settings
        self._kept = WalkSettings(links=settings.links + _SPARE, copies=settings.copies)

    def catch_up(self, wrap: Callable[[Sequence[int]], Iterable[int]] = iter) -> int:
        """Find the neighbours of all shapes that have none, or too few since others were removed.

        Parameters
        ----------
        wrap : callable, optional
            Wraps the loop over the shapes, as tqdm does.

        Returns
        -------
        count : int
            Number of shapes.
        """
        last_id, count = 0, self._replace_removed(wrap)
        while page := self._store.without_neighbours(last_id, _PAGE):
            self.add(wrap(page))
            last_id, count = page[-1], count + len(page)
        return count

    def add(self, shape_ids: Iterable[int]) -> None:
        """Find the neighbours of new shapes, and let these be neighbours of others.

        Parameters
        ----------
        shape_ids : iterable of int
            Of shapes in the library; unknown ones are passed over.
        """
        changed: dict[int, Neighbours] = {}
        for shape_id in shape_ids:
            others = [other for other in self._find(shape_id) if other != shape_id]
            distances = self._pairs.between(shape_id, others)
            there = np.flatnonzero(np.isfinite(distances))
            ids, away = np.array(others, np.int64)[there], distances[there]
            known = self._store.neighbours([other for other in ids.tolist() if other not in changed])
            known = {**known, **{other: changed[other] for other in ids.tolist() if other in changed}}
            changed[shape_id] = self._nearest(ids, away)
            for other, distance in zip(ids.tolist(), away.tolist(), strict=True):
                if other in known:
                    own = self._with(known[other], shape_id, distance)
                    if own is not None:
                        changed[other] = own
        if changed:
            self._store.put_neighbours(changed)

    def _replace_removed(self, wrap: Callable[[Sequence[int]], Iterable[int]]) -> int:
        """Find the neighbours anew of shapes most of whose neighbours were removed."""
        shape_ids: list[int] = all_codes(self._store, "codes", self._code_bytes)[0].tolist()
        there = set(shape_ids)
        lacking: list[int] = []
        for start in range(0, len(shape_ids), _PAGE):
            rows = self._store.neighbours(shape_ids[start : start + _PAGE])
            lacking += [
                shape_id
                for shape_id, (ids, _) in rows.items()
                if len(there.intersection(ids.tolist())) < min(len(ids), self._settings.links)
            ]
        self.add(wrap(lacking))
        return len(lacking)

    def _nearest(self, ids: NDArray[np.int64], distances: FloatArray) -> Neighbours:
        chosen = links_of(distances, self._kept)
        return ids[chosen], distances[chosen].astype(np.float32)

    def _with(self, known: Neighbours, shape_id: int, distance: float) -> Neighbours | None:
        """Add a shape to the neighbours of another one; None if it is not one of the nearest."""
        ids, distances = known
        if len(ids) >= self._kept.links + self._kept.copies and distance >= distances.max(initial=0):
            return None
        if shape_id in ids:
            return None
        nearest = self._nearest(np.append(ids, shape_id), np.append(distances.astype(float), distance))
        return nearest if shape_id in nearest[0] else None

    def distances(self, shape_ids: Sequence[int], distances: ArrayLike) -> FloatArray:
        """Lower the distances of matches that a walk from the query over their neighbours visits.

        Parameters
        ----------
        shape_ids : sequence of n int
            Best first.
        distances : (n,) array_like
            From the query, in ascending order, as `PairDistances` measures them.

        Returns
        -------
        distances : (n,) array
            See `walked_distances`.
        """
        away = np.asarray(distances, float)
        near = list(shape_ids[: self._settings.walked])
        rows = self._store.neighbours(near)
        beyond = {other for ids, _ in rows.values() for other in ids.tolist()}.difference(near)
        rows |= self._store.neighbours(sorted(beyond))
        visited = np.zeros(len(away))
        visited[: len(near)] = self._visits(near, away[: len(near)], rows)
        return walked_distances(away, visited, self._settings)

    def _visits(self, near: list[int], away: FloatArray, rows: Mapping[int, Neighbours]) -> FloatArray:
        """Count the visits of the matches `near` in a walk from the query."""
        shape_ids = np.array([*near, *sorted(rows.keys() - set(near))], np.int64)
        query = len(shape_ids)
        places = {shape_id: place for place, shape_id in enumerate(shape_ids.tolist())}
        owners = np.repeat([places[shape_id] for shape_id in rows], [len(ids) for ids, _ in rows.values()])
        ids = np.concatenate([np.empty(0, np.int64), *(ids for ids, _ in rows.values())])
        lengths = np.concatenate([np.empty(0), *(distances for _, distances in rows.values())])
        ends = np.array([places.get(other, -1) for other in ids.tolist()], np.int64)
        is_known = ends >= 0
        owners, ends, lengths = owners[is_known].astype(np.int64), ends[is_known], lengths[is_known]
        own = links_of_all(owners, lengths, self._settings)
        chosen = links_of(away, self._settings)
        # The query would be one of the neighbours of these matches if it were in the library.
        farthest = np.zeros(query)
        np.maximum.at(farthest, owners[own], lengths[own])
        back = np.flatnonzero((away > COPY_DISTANCE) & (away <= farthest[: len(near)]))
        weights = link_weights(
            np.concatenate([np.full(len(chosen), query), owners[own], back]),
            np.concatenate([chosen, ends[own], np.full(len(back), query)]),
            np.concatenate([away[chosen], lengths[own], away[back]]),
            query + 1,
        )
        return visits(weights, query, self._settings.damping)[: len(near)]
