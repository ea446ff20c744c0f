# SPDX-License-Identifier: MIT
"""Queries: examples of shapes that are searched for, negative examples, and their surface samples.

Each example has its own distance to a shape of the library; two rules combine them to one:

- **Several examples.** d = (d₁ d₂ … dₙ)^(1/n). The log odds behind a similarity are linear in log d (see
  `ShapeModel.similarity`), so that this averages the log odds of the examples: a shape that all of them find
  near comes before one that is nearer to one of them and far from another. A copy of an example keeps
  distance 0.
- **Negative examples.** A shape is what the examples show, with odds o = (h/d)^p; or what the nearest
  negative example shows, with odds w o⁻, o⁻ likewise; or neither, with odds 1. The probability of the first
  is o / (1 + o + w o⁻), and d (1 + w o⁻)^(1/p) is the distance that has this similarity. A shape far from all
  negative examples keeps its place, one near to one of them falls, and its copies come last.

With one example and no negative ones, both rules change nothing. ``docs/measurements/search.md`` compares the
rules with others. Geometric verification then lowers distances as in any other search: each match is aligned
with the nearest example.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.match import DISTANCE_DECIMALS, Match
from shapegoogle_core.library.search.settings import RerankSettings
from shapegoogle_core.library.storage.signatures import round_bags
from shapegoogle_core.mesh import MeshLike, is_mesh_like
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.model.signature import ShapeSignature
from shapegoogle_core.registration import SHARED_SCALES, PreparedSample, SurfaceSample

__all__ = [
    "FARTHEST",
    "Query",
    "QuerySample",
    "QuerySamples",
    "QueryShape",
    "QueryShapes",
    "as_query_shapes",
    "pool_distances",
]

FARTHEST = 2.0
"""Cosine distance of opposite bags, shown instead of infinity for copies of negative examples."""


QueryShape: TypeAlias = MeshLike | ShapeSignature
"""A mesh, see `MeshLike`, or a signature."""

QueryShapes: TypeAlias = QueryShape | Sequence[QueryShape]
"""One or several of them."""


class Query:
    """Examples of shapes that are searched for, and negative examples, prepared to be compared with bags.

    Parameters
    ----------
    model : ShapeModel
        Model that described all of them.
    like : sequence of ShapeSignature
        At least one.
    unlike : sequence of ShapeSignature, optional
        Negative examples.
    unlike_weight : float, optional
        w above.

    Attributes
    ----------
    examples : tuple of ShapeSignature
        The positive examples.
    several, has_unlike : bool
        Whether there are several positive examples, and negative ones.
    codes, projections : list of (s/8,) array of uint8, list of (s,) array
        Binary code of each positive example, and its projections before taking signs.
    sampled : list of ShapeSignature
        The positive examples that have a sample of their surface.
    """

    def __init__(
        self,
        model: ShapeModel,
        like: Sequence[ShapeSignature],
        unlike: Sequence[ShapeSignature] = (),
        unlike_weight: float = RerankSettings.unlike_weight,
    ) -> None:
        self._model = model
        self._unlike_weight = unlike_weight
        # One by one: the last bits of a product depend on the number of its rows.
        bags = [round_bags(signature.bags)[None] for signature in like]
        examples = [(one, model.embed(one)) for one in bags]
        self._like = [model.comparable(*example) for example in examples]
        self._unlike = [model.comparable(round_bags(signature.bags)[None]) for signature in unlike]
        own = [model.background_distances(*example) for example in examples]
        self._background_distance = (
            None if model.background is None else float(pool_distances(np.array(own, np.float64))[0])
        )
        self.examples = tuple(like)
        self.several = len(like) > 1
        self.has_unlike = bool(unlike)
        self.codes: list[NDArray[np.uint8]] = [signature.code for signature in like]
        self.projections: list[NDArray[np.float32]] = [
            model.code_projections(*example)[0] for example in examples
        ]
        self._sampled = [index for index, signature in enumerate(like) if signature.sample is not None]
        self.sampled: list[ShapeSignature] = [like[index] for index in self._sampled]

    def distances(self, vectors: FloatBags) -> FloatArray:
        """Compute the distances of shapes from the query.

        Parameters
        ----------
        vectors : (n, p) array
            Their bags, from `ShapeModel.comparable`.

        Returns
        -------
        distances : (n,) array
            ≥ 0, rounded; infinite for copies of negative examples.
        """
        distances = pool_distances(self._to(self._like, vectors))
        if self._unlike:
            likeness = self._model.similarity(self._to(self._unlike, vectors).min(axis=0))
            copies = likeness == 1
            odds = likeness / np.where(copies, 1, 1 - likeness)
            distances = distances * (1 + self._unlike_weight * odds) ** (1 / self._model.similarity_slope)
            # Copies of both kinds of examples too: the user does not want them.
            distances[copies] = np.inf
        return np.asarray(np.round(distances, DISTANCE_DECIMALS))

    def typical_distances(self, background: FloatArray | None) -> FloatArray | None:
        """Compute the typical distances of shapes and query, see `ShapeModel.typical_distances`.

        Parameters
        ----------
        background : (n,) array or None
            Of the shapes, from `ShapeModel.background_distances`.

        Returns
        -------
        typical : (n,) array or None
            Pooled over the examples as `distances` are; None for a model without a background.
        """
        if background is None or self._background_distance is None:
            return None
        return np.sqrt(self._background_distance * background)

    def nearest_samples(self, vectors: FloatBags) -> NDArray[np.intp]:
        """Find the nearest example of each shape, among those with a surface.

        Parameters
        ----------
        vectors : (n, p) array
            As for `distances`.

        Returns
        -------
        positions : (n,) array of int
            Positions in `sampled`.
        """
        examples = [self._like[index] for index in self._sampled]
        nearest: NDArray[np.intp] = self._to(examples, vectors).argmin(axis=0)
        return nearest

    def _to(self, examples: Sequence[NDArray[np.float32]], vectors: NDArray[np.float32]) -> FloatArray:
        """Distances (examples, n), rounded so that copies are recognised despite their last bits."""
        metric = self._model.settings.metric
        distances = np.stack([row_distances(metric, example, vectors) for example in examples])
        return np.asarray(np.round(distances, DISTANCE_DECIMALS))


def pool_distances(distances: FloatArray) -> FloatArray:
    """Combine the distances to several examples by their geometric mean.

    Parameters
    ----------
    distances : (examples, n) array
        ≥ 0.

    Returns
    -------
    distances : (n,) array
        0 where one of them is 0. The distances to a single example are returned unchanged.
    """
    if len(distances) == 1:
        return np.asarray(distances[0])
    with np.errstate(divide="ignore"):
        return np.asarray(np.exp(np.log(distances).mean(axis=0)))


class QuerySample:
    """A surface sample of one example of the query.

    Parameters
    ----------
    prepared : PreparedSample

    Attributes
    ----------
    prepared : PreparedSample
    supports : dict of int to array
        What is known of the support of shapes at each of `SHARED_SCALES`, by shape id.
    """

    def __init__(self, prepared: PreparedSample) -> None:
        self.prepared = prepared
        self.supports: dict[int, NDArray[np.float32]] = {}

    @cached_property
    def shared(self) -> PreparedSample:
        """The sample at more scales, which only searches for shapes with common parts need."""
        return self.prepared.at_other_scales(SHARED_SCALES)


class QuerySamples:
    """Samples of all examples of the query.

    Each match is aligned with one of them, so that several take no longer than one.

    Parameters
    ----------
    samples : sequence of PreparedSample
    nearest : callable
        Finds the position of the sample that each of some matches is aligned with, by shape id; where it
        names none, the first one is used. Called only if there are several samples.

    Attributes
    ----------
    examples : list of QuerySample
    surfaces : dict of int to SurfaceSample or None
        Samples of the shapes that this search has read, by shape id; see `remembered`.
    """

    def __init__(
        self, samples: Sequence[PreparedSample], nearest: Callable[[Sequence[Match]], Mapping[int, int]]
    ) -> None:
        self.examples = [QuerySample(sample) for sample in samples]
        self.surfaces: dict[int, SurfaceSample | None] = {}
        self._nearest = nearest
        self._chosen: dict[int, int] = {}

    def choose(self, matches: Sequence[Match]) -> None:
        """Choose the sample for each of these matches."""
        if len(self.examples) > 1:
            self._chosen.update(self._nearest(matches))

    def of(self, match: Match) -> QuerySample:
        """Return the sample that a match is aligned with."""
        return self.examples[self._chosen.get(match.shape_id, 0)]


def as_query_shapes(shapes: QueryShapes) -> list[QueryShape]:
    """Make a list of one or several shapes.

    Parameters
    ----------
    shapes : MeshLike, ShapeSignature, or sequence of them
        Anything else is treated as one mesh, and refused as such when it is described.

    Returns
    -------
    shapes : list of MeshLike or ShapeSignature
    """
    if isinstance(shapes, list | tuple) and not is_mesh_like(shapes):
        return list(shapes)
    return [cast(QueryShape, shapes)]
