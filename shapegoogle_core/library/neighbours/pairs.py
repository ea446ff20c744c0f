# SPDX-License-Identifier: MIT
"""Distances between stored shapes, for the neighbour graph."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.library.search.traits.distances import PairDistances as StoredTraits
from shapegoogle_core.library.search.traits.distances import Traits, joined
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["BagPairs", "PairDistances", "TraitPairs", "distances_among"]


class PairDistances(Protocol):
    """Distances between shapes of a library, from what it stores of them."""

    def between(self, shape_id: int, others: Sequence[int]) -> FloatArray:
        """Compute the distances of a shape from others.

        Parameters
        ----------
        shape_id : int
        others : sequence of n int

        Returns
        -------
        distances : (n,) array
            ≥ 0; infinite for shapes that are gone.
        """


def distances_among(
    store: Store, model: ShapeModel, shape_ids: Sequence[int]
) -> tuple[list[int], FloatArray]:
    """Compute the distances of all pairs of some shapes, as `TraitPairs` and `BagPairs` do.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Of the library.
    shape_ids : sequence of int

    Returns
    -------
    shape_ids : list of n int
        In the order of their numbers, without those that are gone.
    distances : (n, n) array
        Symmetric, with zeros on the diagonal.
    """
    numbers, distances = np.sort(shape_ids).tolist(), np.zeros((len(shape_ids), len(shape_ids)))
    if not numbers:
        return [], distances
    if StoredTraits.possible(model):
        stored = StoredTraits(store, model)
        traits = stored.read(numbers)
        numbers = traits.ids.tolist()
        rows = [stored.distances(traits, row, traits) for row in range(len(numbers))]
    else:
        numbers, bags = store.bags(numbers, model.bag_size)
        vectors = model.comparable(bags)
        metric = model.settings.metric
        rows = [row_distances(metric, vectors[row : row + 1], vectors) for row in range(len(numbers))]
    # Of a plain and a distinctive shape each sees the other at its own distance.
    distances = np.array(rows, float).reshape(len(numbers), len(numbers))
    distances = (distances + distances.T) / 2
    np.fill_diagonal(distances, 0)
    return numbers, distances


class BagPairs:
    """Distances of bags, which are kept in memory as far as there is room.

    Parameters
    ----------
    store : Store
    model : ShapeModel
    most : int, optional
        Number of shapes in memory.
    """

    def __init__(self, store: Store, model: ShapeModel, most: int = 20_000) -> None:
        self._store = store
        self._model = model
        self._most = most
        self._vectors: dict[int, FloatBags] = {}

    def between(self, shape_id: int, others: Sequence[int]) -> FloatArray:
        """Compute the distances of a shape from others, see `PairDistances`."""
        self._read([shape_id, *others])
        distances = np.full(len(others), np.inf)
        known = [place for place, other in enumerate(others) if other in self._vectors]
        if shape_id in self._vectors and known:
            vectors = np.stack([self._vectors[others[place]] for place in known])
            away = row_distances(self._model.settings.metric, self._vectors[shape_id][None], vectors)
            distances[known] = np.round(away, DISTANCE_DECIMALS)
        return distances

    def _read(self, shape_ids: Sequence[int]) -> None:
        if len(self._vectors) > self._most:
            self._vectors.clear()
        missing = [shape_id for shape_id in shape_ids if shape_id not in self._vectors]
        if missing:
            found, bags = self._store.bags(missing, self._model.bag_size)
            self._vectors.update(zip(found, self._model.comparable(bags), strict=True))


class TraitPairs:
    """Distances that a search by shape and kind sorts by, with what they need in memory if there is room.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        With a ranking and a background.
    most : int, optional
        Number of shapes in memory.
    """

    def __init__(self, store: Store, model: ShapeModel, most: int = 5_000) -> None:
        self._stored = StoredTraits(store, model)
        self._most = most
        self._known: dict[int, Traits] = {}

    def between(self, shape_id: int, others: Sequence[int]) -> FloatArray:
        """Compute the distances of a shape from others, see `PairDistances`."""
        self._read([shape_id, *others])
        distances = np.full(len(others), np.inf)
        there = [place for place, other in enumerate(others) if other in self._known]
        if shape_id in self._known and there:
            compared = joined([self._known[others[place]] for place in there])
            distances[there] = self._stored.distances(self._known[shape_id], 0, compared)
        return distances

    def _read(self, shape_ids: Sequence[int]) -> None:
        if len(self._known) > self._most:
            self._known.clear()
        missing = [shape_id for shape_id in dict.fromkeys(shape_ids) if shape_id not in self._known]
        if missing:
            found = self._stored.read(missing)
            self._known.update(
                (int(shape_id), found.row(number)) for number, shape_id in enumerate(found.ids)
            )
