# SPDX-License-Identifier: MIT
"""`BagComparison`: the part of a model that compares bags: distances, codes, similarities."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.background import Background
from shapegoogle_core.model.metric import row_distances
from shapegoogle_core.model.settings import ModelSettings
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["BagComparison"]


class BagComparison:
    """Compares bags with what a model has learnt; see `ShapeModel` for its attributes."""

    settings: ModelSettings
    mean: FloatBags
    projection: NDArray[np.float16]
    directions: FloatBags
    thresholds: FloatBags
    similarity_half: float
    similarity_slope: float
    agreement_gain: float
    verified_half: float
    verified_slope: float
    background: Background | None

    @property
    def bag_size(self) -> int:
        """Length B of all bags side by side."""
        return self.settings.bag_size

    @cached_property
    def _projection(self) -> FloatBags:
        return self.projection.astype(np.float32)

    def embed(self, bags: FloatBags) -> FloatBags:
        """Project bags into the space of the learnt metric.

        Parameters
        ----------
        bags : (n, B) array
            Bags of n shapes, see `ShapeSignature.bags`.

        Returns
        -------
        vectors : (n, p) array of float32
            Of unit length.
        """
        vectors = (np.asarray(bags, np.float32) - self.mean) @ self._projection
        vectors /= np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), np.finfo(np.float32).tiny)
        return np.asarray(vectors, dtype=np.float32)

    def codes(self, bags: FloatBags) -> NDArray[np.uint8]:
        """Compute the binary codes y = sign(A f + b) of bags (paper, equation 19).

        Parameters
        ----------
        bags : (n, B) array
            Bags of n shapes.

        Returns
        -------
        codes : (n, s/8) array of uint8
            Packed as by `numpy.packbits`.
        """
        return np.packbits(self.code_projections(bags) > 0, axis=1)

    def code_projections(self, bags: FloatBags, embedded: FloatBags | None = None) -> FloatBags:
        """Compute the projections A f + b, whose signs are the codes.

        Parameters
        ----------
        bags : (n, B) array
            Bags of n shapes.
        embedded : (n, p) array, optional
            f, the result of `embed`, where it is known already.

        Returns
        -------
        projections : (n, s) array of float32
        """
        embedded = self.embed(bags) if embedded is None else embedded
        return np.asarray(embedded @ self.directions.T + self.thresholds, np.float32)

    def comparable(self, bags: FloatBags, embedded: FloatBags | None = None) -> FloatBags:
        """Compute vectors between which `row_distances` is this model's distance.

        Parameters
        ----------
        bags : (n, B) array
            Bags of n shapes.
        embedded : (n, p) array, optional
            The result of `embed`, where it is known already.

        Returns
        -------
        vectors : (n, p) or (n, B) array of float32
            For the metric "cosine" the projected bags; for "l1" the bags, divided by their number.
        """
        if self.settings.metric == "cosine":
            return self.embed(bags) if embedded is None else embedded
        count = sum(len(channel.bags) for channel in self.settings.channels)
        return np.asarray(bags, np.float32) / np.float32(count)

    def distances(self, query: ArrayLike, bags: ArrayLike) -> FloatArray:
        """Compute the distances of one shape's bags from others, by `settings.metric`.

        Parameters
        ----------
        query : (B,) array_like
            Bags of one shape, see `ShapeSignature.bags`.
        bags : (n, B) array_like
            Bags of n shapes.

        Returns
        -------
        distances : (n,) array
            At least 0. For the metric "cosine" 1 - cos of the projections; for "l1" Σ|f - f′|, averaged over
            the bags.

        Raises
        ------
        ModelError
            If the bags are of another length than those of this model.
        """
        query, bags = np.asarray(query, np.float32), np.asarray(bags, np.float32)
        if query.shape != (self.bag_size,) or bags.shape[1:] != (self.bag_size,):
            raise ModelError(
                f"bags of this model have {self.bag_size} values, but those of the query are {query.shape} "
                f"and the others {bags.shape}; describe all shapes with this model"
            )
        return row_distances(self.settings.metric, self.comparable(query[None]), self.comparable(bags))

    def verified_distance(self, distance: float, excess: float) -> float:
        """Lower the distance between bags if the two surfaces agree in space.

        d′ = d exp(-k e). The logistic regression behind `similarity` is linear in log d; with the excess e as
        its second variable, k is the ratio of the two coefficients (see `calibrate`).

        Parameters
        ----------
        distance : float
            Distance d from `distances`.
        excess : float
            Agreement e beyond that of unrelated shapes, see `Alignment.excess`.

        Returns
        -------
        distance : float
            d′ ≤ d. Without an agreement it does not change, because bags alone find other poses.
        """
        return distance * math.exp(-self.agreement_gain * excess)

    def background_distances(self, bags: FloatBags, embedded: FloatBags | None = None) -> FloatArray | None:
        """Compute how far shapes are from shapes that have nothing to do with them, see `Background`.

        Parameters
        ----------
        bags : (n, B) array
            Bags of n shapes.
        embedded : (n, p) array, optional
            The result of `embed`, where it is known already.

        Returns
        -------
        distances : (n,) array or None
            Small for plain shapes; None for a model without a background.
        """
        if self.background is None:
            return None
        return self.background.distances(self.settings.metric, self.comparable(bags, embedded))

    def typical_distances(self, query: ArrayLike, bags: FloatBags) -> FloatArray | None:
        """Compute the distances that unrelated shapes as plain as these typically have, see `Background`.

        Parameters
        ----------
        query : (B,) array_like
            Bags of one shape.
        bags : (n, B) array
            Bags of n shapes.

        Returns
        -------
        typical : (n,) array or None
            √(σ σ′) for each pair, for `similarity`; None for a model without a background.
        """
        own = self.background_distances(np.asarray(query, np.float32)[None])
        others = self.background_distances(np.asarray(bags, np.float32))
        return None if own is None or others is None else np.sqrt(own * others)

    def similarity(
        self, distances: ArrayLike, typical: ArrayLike | None = None, *, verified: bool = False
    ) -> FloatArray:
        """Convert distances to similarities from 0 to 1.

        s(d) = 1 / (1 + (d / d_½)^p), fitted on training shapes by logistic regression: the probability that
        a shape at distance d is the same one transformed and not the nearest of fifty different ones, if both
        are equally likely beforehand. Of plain shapes, which resemble many others, d is raised before, see
        `Background`.

        Parameters
        ----------
        distances : (n,) array_like
            From `distances`, or from `verified_distance`.
        typical : (n,) array_like, optional
            From `typical_distances`; without it, all shapes count as distinctive.
        verified : bool, optional
            Whether the distances are verified. An unchanged distance then means a lower similarity than that
            of bags alone, since verification found no agreement.

        Returns
        -------
        similarity : (n,) array
            1 at distance 0, falling towards 0.
        """
        half, slope = self.similarity_half, self.similarity_slope
        if verified:
            half, slope = self.verified_half, self.verified_slope
        weighed = self.weighed_distances(distances, typical, verified=verified)
        return np.asarray(1 / (1 + (weighed / half) ** slope), dtype=np.float64)

    def weighed_distances(
        self, distances: ArrayLike, typical: ArrayLike | None, *, verified: bool = False
    ) -> FloatArray:
        """Raise distances of plain shapes, whose agreement says little; see `Background`.

        Parameters
        ----------
        distances : (n,) array_like
            Between pairs of shapes.
        typical : (n,) array_like or None
            From `typical_distances`.
        verified : bool, optional
            Whether the distances are verified.

        Returns
        -------
        weighed : (n,) array
            The distances themselves without typical distances, and in a model without a background.
        """
        if self.background is None or typical is None:
            return np.asarray(distances, np.float64)
        return self.background.weigh(distances, typical, verified=verified)
