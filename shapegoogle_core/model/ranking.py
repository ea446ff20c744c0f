# SPDX-License-Identifier: MIT
"""`Ranking`: what decides the order of a list of matches, and how likely two shapes are of one kind.

Bags say whether two shapes are the same, whatever their pose; pictures say whether they look alike; simple
measures say whether they are long, flat or hollow. A weighted sum of their distances, the *kind distance* K,
orders shapes of one kind best. But a shape in another pose may look less like itself than like another one.
So the list is not sorted by K but by

    K (1 - exp(-(E / E₀)²))^q (1 + o / o₀) / (1 + o′ / o₀),    E = d / t max(1, t₀ / t)^p,

which is much smaller where the distance d of the bags is small compared with the typical distance t of the
pair, see `Background`, and where the surfaces fit so well that the odds o that the shapes are the same rise
to large ones o′. A typical distance below t₀ is that of plain shapes, or of loose and open triangles. Their
bags say little about them, and must agree even more closely.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration import MeshMeasures, stacked_moments

__all__ = ["FIGURES", "Ranking", "figures_of"]

FIGURES = 12
"""Number of simple measures of a shape."""

# Standardised figures beyond this are outliers, such as of a sheet without thickness.
_LARGEST = 3.0
_TINY = 1e-6
# Larger similarities count as this one: odds must be finite.
_SURELY = 1 - 1e-9


@dataclass(frozen=True, eq=False)
class Ranking:
    """Weights of the kind distance, and its calibration.

    Attributes
    ----------
    view_weight, bag_weight, figure_weight : float
        Of the distances of views, of bags and of simple measures in K; together 1.
    figure_mean, figure_scale : (12,) arrays of float32
        Mean and standard deviation of the simple measures, see `figures_of`.
    unknown_views : float
        Distance of views where one of two shapes has none.
    agreement, power : float
        E₀ and q above.
    distinctive, distrust : float
        t₀ and p above.
    certain_odds : float
        o₀ above: odds of the same shape from which a fit of the surfaces counts.
    likeness_half, likeness_slope : float
        Calibration of the likeness 1 / (1 + (K / half)^slope): the probability that two shapes are of one
        kind and not two neighbours of different kinds, if both are equally likely beforehand.

    Raises
    ------
    ModelError
        If a number is not finite or out of range.
    """

    view_weight: float
    bag_weight: float
    figure_weight: float
    figure_mean: NDArray[np.float32]
    figure_scale: NDArray[np.float32]
    unknown_views: float
    agreement: float
    power: float
    distinctive: float
    distrust: float
    certain_odds: float
    likeness_half: float
    likeness_slope: float

    def __post_init__(self) -> None:
        weights = (
            self.view_weight,
            self.bag_weight,
            self.figure_weight,
            self.unknown_views,
            self.distrust,
        )
        positive = (
            self.agreement,
            self.power,
            self.distinctive,
            self.certain_odds,
            self.likeness_half,
            self.likeness_slope,
        )
        fits = (
            all(0 <= weight < np.inf for weight in weights)
            and all(0 < value < np.inf for value in positive)
            and self.figure_mean.shape == self.figure_scale.shape == (FIGURES,)
            and np.isfinite(self.figure_mean).all()
            and bool((self.figure_scale > 0).all())
        )
        if not fits:
            raise ModelError("the model's ranking is damaged: its numbers are out of range")

    def standardised(self, figures: NDArray[np.float32]) -> NDArray[np.float32]:
        """Standardise simple measures (n, 12); those that are not known count as usual ones."""
        scaled = (figures - self.figure_mean) / self.figure_scale
        return np.asarray(np.clip(np.nan_to_num(scaled, nan=0.0), -_LARGEST, _LARGEST), np.float32)

    def kind_distances(self, bags: ArrayLike, views: ArrayLike, figures: ArrayLike) -> FloatArray:
        """Compute the kind distances K of pairs.

        Parameters
        ----------
        bags, figures : (n,) array_like
            Distances of bags, and root mean square differences of standardised measures.
        views : (n,) array_like
            Distances of views; NaN where one of the two shapes has none.

        Returns
        -------
        distances : (n,) array
        """
        seen = np.nan_to_num(np.asarray(views, np.float64), nan=self.unknown_views)
        return np.asarray(
            self.view_weight * seen
            + self.bag_weight * np.asarray(bags, np.float64)
            + self.figure_weight * np.asarray(figures, np.float64)
        )

    def sorting_distances(self, kind: ArrayLike, bags: ArrayLike, typical: ArrayLike) -> FloatArray:
        """Compute the distances that a list of both, the same shape and the same kind, is sorted by.

        Parameters
        ----------
        kind : (n,) array_like
            Kind distances.
        bags, typical : (n,) array_like
            Distances of bags, not verified, and typical distances.

        Returns
        -------
        distances : (n,) array
            0 for equal bags, at most `kind`.
        """
        usual = np.asarray(typical, np.float64)
        distrusted = np.maximum(1, self.distinctive / usual) ** self.distrust
        agreement = np.asarray(bags, np.float64) / usual * distrusted
        gate = (1 - np.exp(-((agreement / self.agreement) ** 2))) ** self.power
        return np.asarray(np.asarray(kind, np.float64) * gate, np.float64)

    def verified_distances(
        self, sorting: ArrayLike, similarity: ArrayLike, verified: ArrayLike
    ) -> FloatArray:
        """Lower sorting distances where the surfaces fit so well that shapes are surely the same.

        Parameters
        ----------
        sorting : (n,) array_like
            From `sorting_distances`.
        similarity, verified : (n,) array_like
            Similarities before and after verification, from 0 to 1.

        Returns
        -------
        distances : (n,) array
            At most `sorting`; unchanged where verification has found nothing.
        """
        before, after = (np.minimum(np.asarray(each, np.float64), _SURELY) for each in (similarity, verified))
        odds, higher = before / (1 - before), after / (1 - after)
        factor = (1 + odds / self.certain_odds) / (1 + higher / self.certain_odds)
        return np.asarray(np.asarray(sorting, np.float64) * np.minimum(factor, 1), np.float64)

    def likeness(self, kind: ArrayLike) -> FloatArray:
        """Convert kind distances to likenesses from 0 to 1."""
        ratio = np.asarray(kind, np.float64) / self.likeness_half
        return np.asarray(1 / (1 + ratio**self.likeness_slope), dtype=np.float64)


def figures_of(
    measures: Sequence[MeshMeasures | None], areas: ArrayLike, extents: ArrayLike
) -> NDArray[np.float32]:
    """Compute simple measures of shapes, which do not depend on their size.

    Parameters
    ----------
    measures : sequence of n (MeshMeasures or None)
    areas : (n,) array_like
    extents : (n, 3) array_like
        Side lengths of the bounding boxes; zeros if they are not known.

    Returns
    -------
    figures : (n, 12) array of float32
        Moments of the points and of the normals; proportions of the bounding box, area for its size, share of
        curved surface. NaN where they are not known.
    """
    figures = np.full((len(measures), FIGURES), np.nan, np.float32)
    known = [(row, own) for row, own in enumerate(measures) if own is not None and own.area > 0]
    if known:
        rows = [row for row, _ in known]
        moments = stacked_moments([own for _, own in known])
        figures[rows, :5] = np.log(np.maximum(moments[:, [0, 1, 2, 6, 7]], _TINY))
        figures[rows, 5:8] = moments[:, 3:6]
        figures[rows, 8] = [own.curved for _, own in known]
    sides = np.sort(np.asarray(extents, np.float64).reshape(len(measures), 3), axis=1)
    sized = sides[:, 2] > 0
    shortest, middle, longest = sides[sized].T
    figures[sized, 9] = np.log(np.maximum(middle / longest, 1e-3))
    figures[sized, 10] = np.log(shortest / longest + 1e-2)
    figures[sized, 11] = np.log(np.maximum(np.asarray(areas, np.float64)[sized] / longest**2, _TINY))
    return figures
