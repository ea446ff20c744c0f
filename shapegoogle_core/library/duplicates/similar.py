# SPDX-License-Identifier: MIT
"""Groups of similar shapes: leader clustering by the distances of a model."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.library.duplicates.leader_clustering import (
    Clusters,
    Wrapper,
    choose_banding,
    cluster_by_leaders,
)
from shapegoogle_core.library.duplicates.settings import MIN_SIMILARITY
from shapegoogle_core.library.match import DISTANCE_DECIMALS
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ShapeModel, row_distances
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.model.signature import ShapeSignature

__all__ = ["cluster_similar", "distance_at", "group_similar"]

# Share of bits assumed to differ at the limit, for a metric without an angle to derive it from.
DIFFERING_BITS = 0.15


# Shapes whose background distances are computed at once.
_AT_ONCE = 10_000


def distance_at(model: ShapeModel, similarity: float) -> float:
    """Compute the distance at which a model gives a similarity: the inverse of `ShapeModel.similarity`.

    Parameters
    ----------
    model : ShapeModel
    similarity : float
        0 < similarity ≤ 1.

    Returns
    -------
    distance : float
        ≥ 0.

    Raises
    ------
    ValueError
        If the similarity is out of range.
    """
    if not 0 < similarity <= 1:
        raise ValueError(f"a similarity to group by must be above 0 and at most 1, not {similarity}")
    return float(model.similarity_half * (1 / similarity - 1) ** (1 / model.similarity_slope))


def group_similar(
    model: ShapeModel, signatures: Sequence[ShapeSignature], min_similarity: float = MIN_SIMILARITY
) -> list[list[tuple[int, float]]]:
    """Group signatures around the first of each group, as `Library.duplicates` groups similar shapes.

    Parameters
    ----------
    model : ShapeModel
        The model that made the signatures.
    signatures : sequence of ShapeSignature
    min_similarity : float, optional
        Above 0, at most 1.

    Returns
    -------
    groups : list of list of (int, float)
        Position of each member and its similarity to the first one, by falling similarity.

    Raises
    ------
    ValueError
        If `min_similarity` is out of range.
    """
    limit = distance_at(model, min_similarity)
    if not signatures:
        return []
    vectors = model.comparable(np.stack([signature.bags for signature in signatures]))
    codes = np.stack([signature.code for signature in signatures])
    clusters = cluster_similar(model, codes, vectors, np.arange(len(vectors)), limit)
    similarities = model.similarity(clusters.distance)
    return [
        [(int(position), float(similarities[position])) for position in group] for group in clusters.groups()
    ]


def cluster_similar(
    model: ShapeModel,
    codes: NDArray[np.uint8],
    vectors: FloatBags,
    rows: NDArray[np.int64],
    max_distance: float,
    progress: Wrapper = iter,
) -> Clusters:
    """Group shapes around leaders by the distances of a model, rounded like those of a search.

    Distances of plain shapes are raised first, see `ShapeModel.weighed_distances`.

    Parameters
    ----------
    model : ShapeModel
    codes : (m, s/8) array of uint8
        Of the shapes.
    vectors : (n, p) array of float32
        From `ShapeModel.comparable`; may be mapped from a file.
    rows : (m,) array of int64
        Row of each shape in `vectors`.
    max_distance : float
        Largest distance of a member from its leader.
    progress : callable, optional
        Wraps the loop over the shapes, as tqdm does.

    Returns
    -------
    clusters : Clusters
        Of positions among the m shapes.
    """
    background = [
        model.background.distances(model.settings.metric, vectors[rows[start : start + _AT_ONCE]])
        for start in range(0, len(rows), _AT_ONCE)
        if model.background is not None
    ]
    plain = np.concatenate(background) if background else None

    def distances(position: int, others: NDArray[np.int64]) -> FloatArray:
        one = vectors[rows[position]][None]
        away = np.round(row_distances(model.settings.metric, one, vectors[rows[others]]), DISTANCE_DECIMALS)
        return model.weighed_distances(
            away, None if plain is None else np.sqrt(plain[position] * plain[others])
        )

    banding = choose_banding(len(rows), _differing_bits(model, max_distance), model.code_bits)
    return cluster_by_leaders(codes, distances, max_distance, banding, progress)


def _differing_bits(model: ShapeModel, distance: float) -> float:
    """Share of bits in which codes at a distance should differ: θ / π, if the metric has an angle."""
    if model.settings.metric == "cosine":
        return math.acos(max(-1.0, 1 - distance)) / math.pi
    return DIFFERING_BITS
