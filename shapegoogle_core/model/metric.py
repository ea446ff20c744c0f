# SPDX-License-Identifier: MIT
"""Distances between bags, the learnt metric, and the calibration of its distances to probabilities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model.shape_bags import FloatBags

__all__ = [
    "RIVALS",
    "Calibration",
    "calibrate",
    "choose_pairs",
    "learn_projection",
    "rival_pairs",
    "row_distances",
]

RIVALS = 50
"""Number of different shapes whose nearest one competes with a version of the same shape, about."""


def row_distances(metric: str, first: FloatBags, second: FloatBags) -> FloatArray:
    """Compute the distances between the rows of two arrays.

    Parameters
    ----------
    metric : {"cosine", "l1"}
    first, second : (n, p) arrays
        From `ShapeModel.comparable`. Either may have a single row.

    Returns
    -------
    distances : (n,) array
        At least 0.
    """
    if metric == "l1":
        return np.asarray(np.abs(first - second).sum(axis=1, dtype=np.float64))
    return np.asarray(np.clip(1 - (first * second).sum(axis=1, dtype=np.float64), 0, 2))


def learn_projection(
    bags: FloatBags, labels: NDArray[np.int64], dimensions: int, shrinkage: float
) -> tuple[FloatBags, FloatBags]:
    """Learn the metric: regularised linear discriminants of the training shapes.

    Bags are projected to principal components, and these are scaled by the inverse square root of the spread
    within shapes (over their versions), which is shrunk towards a sphere. So directions that augmentations
    change count less.

    Parameters
    ----------
    bags : (n, B) array
    labels : (n,) array of int
        Number of the shape that each bag belongs to.
    dimensions : int
        Maximum of p, which is never more than the dimension that the bags span.
    shrinkage : float
        γ in S = (1 - γ) S_within + γ tr(S_within)/p · I, from 0 to 1.

    Returns
    -------
    mean : (B,) array of float32
    projection : (B, p) array of float32
    """
    mean = bags.mean(axis=0)
    centered = (bags - mean).astype(np.float64)
    if len(centered) > bags.shape[1]:
        variances, components = scipy.linalg.eigh(centered.T @ centered / len(centered))
    else:  # the small side of the Gram matrix
        variances, left = scipy.linalg.eigh(centered @ centered.T / len(centered))
        components = centered.T @ (left / np.sqrt(np.maximum(variances, 1e-300) * len(centered)))
    order = np.argsort(variances)[::-1][:dimensions]
    order = order[variances[order] > 1e-9 * variances.max()]
    components = components[:, order]
    reduced = centered @ components
    _, group = np.unique(labels, return_inverse=True)
    counts = np.bincount(group)
    centers = np.stack([np.bincount(group, column) / counts for column in reduced.T], axis=1)
    residuals = reduced - centers[group]
    within = residuals.T @ residuals / len(residuals)
    sphere = np.trace(within) / len(within)
    shrunk = (1 - shrinkage) * within + shrinkage * sphere * np.eye(len(within))
    values, vectors = scipy.linalg.eigh(shrunk)
    projection = components @ (vectors / np.sqrt(values)) * np.sqrt(sphere)
    return mean.astype(np.float32), projection.astype(np.float32)


def choose_pairs(
    labels: NDArray[np.int64], random: np.random.Generator, count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """Choose equally many positive and negative pairs at random.

    Parameters
    ----------
    labels : (n,) array of int
        Number of the shape that each version belongs to.
    random : numpy.random.Generator
    count : int
        Maximum number of each kind.

    Returns
    -------
    first, second : (P,) arrays of int
        Indices into `labels`.
    similar : (P,) array of bool
        Whether both are versions of the same shape.
    """
    members = [np.flatnonzero(labels == label) for label in np.unique(labels)]
    members = [m for m in members if len(m) > 1]
    positive = [
        random.choice(members[i], 2, replace=False) for i in random.integers(len(members), size=count)
    ]
    negative = random.integers(len(labels), size=(4 * count, 2))
    negative = negative[labels[negative[:, 0]] != labels[negative[:, 1]]][:count]
    pairs = np.concatenate([np.array(positive), negative])
    return pairs[:, 0], pairs[:, 1], np.arange(len(pairs)) < len(positive)


def rival_pairs(
    metric: str,
    vectors: FloatBags,
    labels: NDArray[np.int64],
    random: np.random.Generator,
    count: int = 5_000,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    """Pair versions with another one of the same shape, and with the nearest of `RIVALS` different shapes.

    Random pairs of different shapes are easily distinguished. But a similarity in a list of matches has to
    say whether the best match is the shape itself or only the most similar other one.

    Parameters
    ----------
    metric : {"cosine", "l1"}
    vectors : (n, p) array
        From `ShapeModel.comparable`.
    labels : (n,) array of int
        Number of the shape that each version belongs to.
    random : numpy.random.Generator
    count : int, optional
        Number of pairs of each kind.

    Returns
    -------
    first, second : (P,) arrays of int
        Indices into `vectors`.
    similar : (P,) array of bool
    """
    first, second, similar = choose_pairs(labels, random, count)
    first, second = first[similar], second[similar]
    rivals = min(RIVALS, len(np.unique(labels)) - 1)
    nearest = []
    for index in first:
        others = random.integers(len(labels), size=10 * rivals)
        others = others[labels[others] != labels[index]][:rivals]
        distances = row_distances(metric, vectors[index : index + 1], vectors[others])
        nearest.append(others[distances.argmin()])
    return (
        np.concatenate([first, first]),
        np.concatenate([second, np.array(nearest)]),
        np.arange(2 * len(first)) < len(first),
    )


@dataclass(frozen=True)
class Calibration:
    """Calibration of distances, see `ShapeModel.similarity` and `ShapeModel.verified_distance`.

    Attributes
    ----------
    half : float
        Distance at which the probability is ½ without a spatial agreement.
    slope : float
        p in 1 / (1 + (d / half)^p).
    gain : float
        k in d exp(-k · agreement); 0 without agreements.
    """

    half: float
    slope: float
    gain: float


def calibrate(
    distances: FloatArray, similar: NDArray[np.bool_], agreements: FloatArray | None = None
) -> Calibration:
    """Fit the probability that a pair is similar.

    Logistic regression on the logarithm of the distance and on the agreement, with equal weight for both
    kinds of pairs: log odds = p log(half / d) + k p · agreement.

    Parameters
    ----------
    distances : (P,) array
    similar : (P,) array of bool
    agreements : (P,) array, optional
        Spatial agreement beyond that of unrelated surfaces, see `Alignment.excess`.

    Returns
    -------
    calibration : Calibration

    Raises
    ------
    ModelError
        If similar pairs are not closer than others.
    """
    from sklearn.linear_model import LogisticRegression

    usable = distances > 0
    features = [np.log(distances[usable])]
    if agreements is not None:
        features.append(agreements[usable])
    regression = LogisticRegression(C=1e6, class_weight="balanced")
    regression.fit(np.stack(features, axis=1), similar[usable])
    slope = -float(regression.coef_[0, 0])
    if not slope > 0:
        if agreements is not None:  # they alone tell the pairs apart, so nothing is learnt about distances
            return calibrate(distances, similar)
        raise ModelError("the training shapes cannot be distinguished: give more varied ones")
    gain = 0.0 if agreements is None else float(regression.coef_[0, 1]) / slope
    if gain < 0:  # these agreements are no evidence
        return calibrate(distances, similar)
    return Calibration(float(np.exp(regression.intercept_[0] / slope)), slope, gain)
