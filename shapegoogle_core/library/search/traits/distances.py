# SPDX-License-Identifier: MIT
"""`Traits`: what is compared to order shapes of one kind, for many shapes at once.

Bags, views and simple measures, of examples of a query or of shapes of a library. No surface is read, so that
hundreds of shapes take milliseconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.library.storage.signatures import round_bags
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances
from shapegoogle_core.model.background import Background
from shapegoogle_core.model.ranking import Ranking, figures_of
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.views import ShapeViews

__all__ = ["TraitDistances", "Traits"]


@dataclass(frozen=True, eq=False)
class Traits:
    """Traits of n shapes.

    Attributes
    ----------
    ids : (n,) array of int64
        Of the shapes; zeros for examples of a query.
    vectors : (n, p) array of float32
        Bags, see `ShapeModel.comparable`.
    background : (n,) array
        Background distances.
    views : (n, 2, width) array of int8
    seen : (n,) array of bool
        Whether a shape has views.
    figures : (n, 12) array of float32
        Simple measures, standardised.
    """

    ids: NDArray[np.int64]
    vectors: FloatBags
    background: FloatArray
    views: NDArray[np.int8]
    seen: NDArray[np.bool_]
    figures: NDArray[np.float32]


class TraitDistances:
    """Compares shapes by their traits.

    Parameters
    ----------
    model : ShapeModel
        With a ranking and a background.

    Raises
    ------
    ModelError
        If it lacks one of them; see `TraitDistances.possible`.
    """

    def __init__(self, model: ShapeModel) -> None:
        if model.ranking is None or model.background is None:
            raise ModelError(f"the model {model.name!r} has not learnt to order shapes by kind; take another")
        self._model = model
        self._ranking: Ranking = model.ranking
        self._background: Background = model.background
        self._view_shape = (2, 0) if model.views is None else model.views.shape

    @staticmethod
    def possible(model: ShapeModel) -> bool:
        """Whether a model has what is needed."""
        return model.ranking is not None and model.background is not None

    def of(self, signatures: Sequence[ShapeSignature]) -> Traits:
        """Take the traits of examples of a query.

        Parameters
        ----------
        signatures : sequence of ShapeSignature

        Returns
        -------
        traits : Traits
        """
        described = np.zeros((len(signatures), *self._view_shape), np.int8)
        seen = np.array([signature.views is not None for signature in signatures], bool)
        for row, signature in enumerate(signatures):
            if signature.views is not None and self._model.views is not None:
                described[row] = signature.views.descriptors
        bags = np.stack([round_bags(signature.bags) for signature in signatures])
        figures = figures_of(
            [signature.measures for signature in signatures],
            [signature.area for signature in signatures],
            [signature.extents for signature in signatures],
        )
        vectors = self._model.comparable(bags)
        return Traits(
            ids=np.zeros(len(signatures), np.int64),
            vectors=vectors,
            background=self._background.distances(self._model.settings.metric, vectors),
            views=described,
            seen=seen,
            figures=self._ranking.standardised(figures),
        )

    def kind_distances(self, one: Traits, row: int, others: Traits) -> FloatArray:
        """Compute the kind distances of one shape from others, see `Ranking`.

        Parameters
        ----------
        one : Traits
        row : int
            Its row in `one`.
        others : Traits

        Returns
        -------
        distances : (n,) array
            Rounded like those of a search.
        """
        bags, _, views, figures = self.parts(one, row, others)
        # The last bits of a product depend on the number of its rows.
        return np.asarray(np.round(self._ranking.kind_distances(bags, views, figures), DISTANCE_DECIMALS))

    def distances(self, one: Traits, row: int, others: Traits) -> FloatArray:
        """Compute the distances that a search by shape and kind sorts by, before surfaces are compared.

        Parameters
        ----------
        one : Traits
        row : int
            Its row in `one`.
        others : Traits

        Returns
        -------
        distances : (n,) array
            Rounded like those of a search.
        """
        bags, typical, views, figures = self.parts(one, row, others)
        kind = np.round(self._ranking.kind_distances(bags, views, figures), DISTANCE_DECIMALS)
        sorting = self._ranking.sorting_distances(kind, bags, typical)
        return np.asarray(np.round(sorting, DISTANCE_DECIMALS))

    def parts(
        self, one: Traits, row: int, others: Traits
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Compute what kind distances are made of.

        Parameters
        ----------
        one : Traits
        row : int
            Its row in `one`.
        others : Traits

        Returns
        -------
        bags, typical, views, figures : (n,) arrays
            See `Ranking.kind_distances` and `Ranking.sorting_distances`.
        """
        views = np.full(len(others.ids), np.nan)
        if one.seen[row] and others.seen.any() and self._model.views is not None:
            own = ShapeViews(one.views[row], self._model.views.identifier)
            seen = others.views if others.seen.all() else others.views[others.seen]
            views[others.seen] = self._model.views.distances(own, seen)
        figures = np.sqrt(((others.figures - one.figures[row]) ** 2).mean(axis=1))
        return self._bags(one, row, others), np.sqrt(one.background[row] * others.background), views, figures

    def _bags(self, one: Traits, row: int, others: Traits) -> FloatArray:
        distances = row_distances(self._model.settings.metric, one.vectors[row : row + 1], others.vectors)
        return np.asarray(np.round(distances, DISTANCE_DECIMALS))
