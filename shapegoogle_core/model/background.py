# SPDX-License-Identifier: MIT
"""`Background`: unlike shapes that belong to a model, and tell how distinctive an agreement is.

Two cubes, or a cube and a book, have almost the same bags: plain shapes resemble each other, whatever they
are. Creatures resemble nothing but themselves. So the same distance means different things, and what a
distance means for a shape is learnt from its distances to shapes that have nothing to do with it. They are
fixed when the model is made: the figures of a pair must not depend on the rest of a library.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.metric import row_distances
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = ["Background"]

NEIGHBOUR = 5
"""Which of the nearest background shapes defines the background distance of a shape."""

# Least background distance: one shape may be in the background itself.
_LEAST = 1e-3
# Entries of the table of distances in memory at once.
_ENTRIES_AT_ONCE = 4_000_000


@dataclass(frozen=True, eq=False)
class Background:
    """Unlike shapes, and how much they count.

    The *background distance* σ of a shape is the distance of its bags to the fifth nearest of the
    background. The *typical distance* of a pair is t = √(σ σ′): unrelated shapes as plain as these two are
    about so far apart. Where it is below that of shapes that resemble nothing else, t₀, the distance d of
    the pair counts as d (t₀ / t)ʷ.

    Attributes
    ----------
    vectors : (n, p) array of float16
        Of the shapes, as from `ShapeModel.comparable`.
    distinctive : float
        t₀ above; pairs with a larger typical distance count in full.
    exponent, verified_exponent : float
        w above, for distances of bags and for verified ones. A plain shape fits others in space, too.

    Raises
    ------
    ModelError
        If there are too few shapes, or a number is not finite or out of range.
    """

    vectors: NDArray[np.float16]
    distinctive: float
    exponent: float
    verified_exponent: float

    def __post_init__(self) -> None:
        if self.vectors.ndim != 2 or len(self.vectors) < NEIGHBOUR or not np.isfinite(self.vectors).all():
            raise ModelError(
                f"the model's background is damaged: expected {NEIGHBOUR} or more rows of finite numbers"
            )
        exponents = self.exponent, self.verified_exponent
        if not (0 < self.distinctive < np.inf and all(0 <= exponent < np.inf for exponent in exponents)):
            raise ModelError("the numbers of the model's background are damaged: they must be above 0")

    def weigh(
        self, distances: ArrayLike, typical: ArrayLike, *, verified: bool = False
    ) -> NDArray[np.float64]:
        """Raise distances where an agreement says little.

        Parameters
        ----------
        distances : (n,) array_like
            Of pairs.
        typical : (n,) array_like
            Typical distances of these pairs.
        verified : bool, optional
            Whether the distances are verified.

        Returns
        -------
        weighed : (n,) array
            Not below `distances`; 0 stays 0.
        """
        exponent = self.verified_exponent if verified else self.exponent
        plainness = np.maximum(1.0, self.distinctive / np.asarray(typical, np.float64))
        return np.asarray(np.asarray(distances, np.float64) * plainness**exponent, dtype=np.float64)

    @cached_property
    def _vectors(self) -> FloatBags:
        return self.vectors.astype(np.float32)

    def distances(self, metric: str, vectors: FloatBags) -> FloatArray:
        """Compute the background distances of shapes.

        Parameters
        ----------
        metric : {"cosine", "l1"}
            Of the model.
        vectors : (m, p) array
            From `ShapeModel.comparable`.

        Returns
        -------
        distances : (m,) array
            Above 0.
        """
        at_once = max(1, _ENTRIES_AT_ONCE // len(self.vectors))
        found = [
            self._fifth_nearest(metric, vectors[start : start + at_once])
            for start in range(0, len(vectors), at_once)
        ]
        return np.asarray(np.maximum(np.concatenate([np.empty(0), *found]), _LEAST), np.float64)

    def _fifth_nearest(self, metric: str, vectors: FloatBags) -> FloatArray:
        if metric == "cosine":
            distances = (1 - vectors @ self._vectors.T).astype(np.float64)
        else:
            distances = np.stack([row_distances(metric, one[None], self._vectors) for one in vectors])
        nearest = np.partition(distances, NEIGHBOUR - 1, axis=1)[:, NEIGHBOUR - 1]
        # The last bits of a product depend on the number of its rows.
        return np.asarray(np.round(nearest, 6))
