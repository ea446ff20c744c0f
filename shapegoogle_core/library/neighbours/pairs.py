# SPDX-License-Identifier: MIT
"""Distances between stored shapes, for the neighbour graph."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["BagPairs", "PairDistances"]


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
