# SPDX-License-Identifier: MIT
"""Bags and traits of the shapes of a library, read once and kept in memory."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.search.traits.distances import TraitDistances, Traits
from shapegoogle_core.library.search.traits.rows import Rows, ShapeRows
from shapegoogle_core.library.storage.signatures import stored_views, unpack_measures
from shapegoogle_core.library.storage.store import Store
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.model.ranking import figures_of
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["StoredBags", "StoredTraits"]

# Shapes in memory: their views take 8 kB each, their bags 2 kB.
_MOST = 5_000
# The last bits of a product are the same for any number of rows from this one on.
_FEWEST = 16


class StoredBags:
    """Bags of the shapes of a library, ready to be compared.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes.
    most : int, optional
        Number of shapes in memory.
    """

    def __init__(self, store: Store, model: ShapeModel, most: int = _MOST) -> None:
        self._store = store
        self._model = model
        self._rows = ShapeRows(self._read, most)

    def read(self, shape_ids: Sequence[int]) -> tuple[NDArray[np.int64], FloatBags, FloatArray | None]:
        """Return the bags of shapes, from memory where they are known.

        Parameters
        ----------
        shape_ids : sequence of int

        Returns
        -------
        shape_ids : (n,) array of int64
            In this order. Of those that are not in memory, shapes that are gone are left out.
        vectors : (n, p) array
            See `ShapeModel.comparable`.
        background : (n,) array or None
            See `ShapeModel.background_distances`.
        """
        found, (vectors, background) = self._rows.of(shape_ids)
        return found, vectors, None if self._model.background is None else background

    def _read(self, shape_ids: Sequence[int]) -> tuple[Sequence[int], Rows]:
        found, bags = self._store.bags(shape_ids, self._model.bag_size)
        padded = np.concatenate([bags, np.repeat(bags[:1], max(0, _FEWEST - len(bags)), axis=0)])
        embedded = self._model.embed(padded)
        vectors = self._model.comparable(padded, embedded)
        background = self._model.background_distances(padded, embedded)
        if background is None:
            background = np.zeros(len(padded))
        return found, (vectors[: len(found)], background[: len(found)])


class StoredTraits(TraitDistances):
    """Compares shapes of a library by their traits.

    Parameters
    ----------
    store : Store
    model : ShapeModel
        Model that described the shapes; with a ranking and a background.
    bags : StoredBags, optional
        Of the same library, where they are in memory for other comparisons too.
    most : int, optional
        Number of shapes in memory.

    Raises
    ------
    ModelError
        If the model lacks one of them; see `TraitDistances.possible`.
    """

    def __init__(
        self, store: Store, model: ShapeModel, bags: StoredBags | None = None, most: int = _MOST
    ) -> None:
        super().__init__(model)
        self._store = store
        self._stored = StoredBags(store, model, most) if bags is None else bags
        self._rows = ShapeRows(self._read, most)

    def read(self, shape_ids: Sequence[int]) -> Traits:
        """Return the traits of shapes, from memory where they are known.

        Parameters
        ----------
        shape_ids : sequence of int

        Returns
        -------
        traits : Traits
            In this order. Of those that are not in memory, shapes that are gone are left out.
        """
        found, (views, seen, figures) = self._rows.of(shape_ids)
        there, vectors, background = self._stored.read(found.tolist())
        if len(there) < len(found):  # removed since their views were read
            kept = np.isin(found, there)
            views, seen, figures = views[kept], seen[kept], figures[kept]
        assert background is not None  # the model has a background
        return Traits(there, vectors, background, views, seen, figures)

    def _read(self, shape_ids: Sequence[int]) -> tuple[Sequence[int], Rows]:
        with self._store.snapshot():
            records = self._store.shapes(shape_ids)
            found = [record.shape_id for record in records]
            measures = unpack_measures(self._store, found)
            with_views, views = stored_views(self._store, self._model, found)
        seen = np.isin(found, with_views)
        described = np.zeros((len(found), *self._view_shape), np.int8)
        if len(views):
            described[seen] = views  # both in the order of ids
        figures = figures_of(
            [measures.get(shape_id) for shape_id in found],
            [record.area for record in records],
            [record.extents for record in records],
        )
        return found, (described, seen, self._ranking.standardised(figures))
