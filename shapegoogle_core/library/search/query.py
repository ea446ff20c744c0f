# SPDX-License-Identifier: MIT
"""A question with examples: shapes that what is looked for is like, and shapes that it is not like.

Each example has its say as in a search of its own, by its distance; two rules make one distance of them:

- **Like several.** d = (d₁ d₂ … dₙ)^(1/n). The log odds behind a similarity are linear in log d (see
  `ShapeModel.similarity`), so that this averages the log odds that the examples give: what all of them find
  near comes before what one finds nearer still and another one far. A copy of an example keeps distance 0. On
  creatures the arithmetic mean ranks as well, but puts an example's own copy behind others; the smallest
  distance ranks worse, and the largest much worse, for one bad example spoils it.
- **Not like others.** A shape is what the examples mean, with odds o = (h/d)^p; or what the nearest example
  of the other kind means, with odds w o⁻, o⁻ likewise; or neither, with odds 1. The probability of the first
  is o / (1 + o + w o⁻), and d (1 + w o⁻)^(1/p) is the distance that has it as its similarity. What is far
  from all that is not meant stays where it is, what is near to it falls, its copies come last. w < 1, for
  what is marked stands among the best matches and is much like what is meant: with w = 1 a right match that
  was worse described than the marked one would fall with it.

Where bags are not sure enough, geometry lowers the distance that the rules make, as it does that of an
ordinary query: each match is laid over the example of what is looked for that is nearest to it.

One example, and none of the other kind, is an ordinary query: both rules then change nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.library.storage.bag_precision import round_bags
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import SurfaceSample

__all__ = ["FARTHEST", "Question", "pool_distances"]

# w. On creatures (31 kinds, three individuals each, the best wrong match marked) 1, 3/8 and 1/8 move another
# pose of the marked one to the end alike, but only the last takes nothing from damaged queries.
_UNLIKE_WEIGHT = 1 / 8

FARTHEST = 2.0
"""Cosine distance of opposite bags: what a question wants least is shown here instead of at infinity."""


class Question:
    """Examples of what is looked for and of what is not, ready to be compared with bags.

    Parameters
    ----------
    model : ShapeModel
        The one that described all of them.
    like : sequence of ShapeSignature
        At least one.
    unlike : sequence of ShapeSignature, optional
    """

    def __init__(
        self, model: ShapeModel, like: Sequence[ShapeSignature], unlike: Sequence[ShapeSignature] = ()
    ) -> None:
        self._model = model
        # One by one: the last bits of a product depend on how many rows it has.
        bags = [round_bags(signature.bags)[None] for signature in like]
        examples = [(one, model.embed(one)) for one in bags]
        self._like = [model.comparable(*example) for example in examples]
        self._unlike = [model.comparable(round_bags(signature.bags)[None]) for signature in unlike]
        self.codes: list[NDArray[np.uint8]] = [signature.code for signature in like]
        self.projections: list[NDArray[np.float32]] = [
            model.code_projections(*example)[0] for example in examples
        ]
        self._sampled = [index for index, signature in enumerate(like) if signature.sample is not None]
        self.samples: list[SurfaceSample] = [
            signature.sample for signature in like if signature.sample is not None
        ]

    @property
    def several(self) -> bool:
        """Whether it has several examples of what is looked for."""
        return len(self._like) > 1

    @property
    def has_unlike(self) -> bool:
        """Whether it says what is not looked for."""
        return bool(self._unlike)

    def distances(self, bags: NDArray[np.float32]) -> FloatArray:
        """Distance of shapes from what is asked for.

        Parameters
        ----------
        bags : (n, B) array

        Returns
        -------
        distances : (n,) array
            ≥ 0, rounded; infinite for copies of what it is not like.
        """
        vectors = self._model.comparable(bags)
        distances = pool_distances(self._to(self._like, vectors))
        if self._unlike:
            likeness = self._model.similarity(self._to(self._unlike, vectors).min(axis=0))
            copies = likeness == 1
            odds = likeness / np.where(copies, 1, 1 - likeness)
            distances = distances * (1 + _UNLIKE_WEIGHT * odds) ** (1 / self._model.similarity_slope)
            # Also of what is a copy of both kinds of examples: it was said not to be meant.
            distances[copies] = np.inf
        return np.asarray(np.round(distances, DISTANCE_DECIMALS))

    def nearest_samples(self, bags: NDArray[np.float32]) -> NDArray[np.intp]:
        """Which of `samples` is of the example that each shape is nearest to.

        Parameters
        ----------
        bags : (n, B) array

        Returns
        -------
        positions : (n,) array of int
        """
        vectors = self._model.comparable(bags)
        examples = [self._like[index] for index in self._sampled]
        nearest: NDArray[np.intp] = self._to(examples, vectors).argmin(axis=0)
        return nearest

    def _to(self, examples: Sequence[NDArray[np.float32]], vectors: NDArray[np.float32]) -> FloatArray:
        """Distances (examples, n), rounded: a copy must not seem to be none by its last bits."""
        metric = self._model.settings.metric
        distances = np.stack([row_distances(metric, example, vectors) for example in examples])
        return np.asarray(np.round(distances, DISTANCE_DECIMALS))


def pool_distances(distances: FloatArray) -> FloatArray:
    """Make one distance of those to several examples: their geometric mean.

    Parameters
    ----------
    distances : (examples, n) array
        ≥ 0.

    Returns
    -------
    distances : (n,) array
        0 where one of them is 0. Of one example: as they are, to the last bit.
    """
    if len(distances) == 1:
        return np.asarray(distances[0])
    with np.errstate(divide="ignore"):
        return np.asarray(np.exp(np.log(distances).mean(axis=0)))
