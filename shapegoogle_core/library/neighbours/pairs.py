# SPDX-License-Identifier: MIT
"""Distances between stored shapes, for the neighbour graph."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.library.search.traits.stored import StoredBags, StoredTraits
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances

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
    """Distances of bags.

    Parameters
    ----------
    model : ShapeModel
    bags : StoredBags
        Of the library.
    """

    def __init__(self, model: ShapeModel, bags: StoredBags) -> None:
        self._model = model
        self._bags = bags

    def between(self, shape_id: int, others: Sequence[int]) -> FloatArray:
        """Compute the distances of a shape from others, see `PairDistances`."""
        there, vectors, _ = self._bags.read([shape_id, *others])
        distances = np.full(len(others), np.inf)
        if len(there) and there[0] == shape_id:
            away = row_distances(self._model.settings.metric, vectors[:1], vectors[1:])
            distances[np.isin(others, there)] = np.round(away, DISTANCE_DECIMALS)
        return distances


class TraitPairs:
    """Distances that a search by shape and kind sorts by.

    Parameters
    ----------
    traits : StoredTraits
        Of the library.
    """

    def __init__(self, traits: StoredTraits) -> None:
        self._traits = traits

    def between(self, shape_id: int, others: Sequence[int]) -> FloatArray:
        """Compute the distances of a shape from others, see `PairDistances`."""
        traits = self._traits.read([shape_id, *others])
        distances = np.full(len(others), np.inf)
        if len(traits.ids) and traits.ids[0] == shape_id:
            distances[np.isin(others, traits.ids)] = self._traits.distances(traits, 0, traits)[1:]
        return distances
