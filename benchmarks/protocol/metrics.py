# SPDX-License-Identifier: MIT
"""Measures of retrieval: ranks, mean average precision by strength, ROC, and scores of categories.

Only the order of distances matters: any increasing function of them has the same scores. Shapes at equal
distances, which are frequent with binary codes, share the mean of their ranks, so that ties do not favour a
query by chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "AVERAGE",
    "CLASSES",
    "STRENGTHS",
    "CategoryScores",
    "PrecisionRecall",
    "Roc",
    "category_scores",
    "precision_recall",
    "ranks",
    "roc",
    "strength_table",
]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

STRENGTHS = (1, 2, 3, 4, 5)

CLASSES = (
    "isometry",
    "topology",
    "holes",
    "micro_holes",
    "scale",
    "local_scale",
    "sampling",
    "noise",
    "shot_noise",
    "partial",
    "mixed",
)
"""Transformation classes in the order of the tables."""

AVERAGE = "average"
"""Name of the row of a strength table that averages the classes."""


@dataclass(frozen=True, eq=False)
class Roc:
    """A receiver operating characteristic.

    Attributes
    ----------
    false_positive_rate, true_positive_rate : (t,) array
        From (0, 0) to (1, 1), one point for each distinct distance taken as the threshold.
    equal_error_rate : float
        False positive rate where it equals the false negative rate.
    """

    false_positive_rate: FloatArray
    true_positive_rate: FloatArray
    equal_error_rate: float

    def points(self, most: int = 200) -> list[list[float]]:
        """List [false positive rate, true positive rate] for a plot with a logarithmic x axis.

        Parameters
        ----------
        most : int
            Largest number of points, spread evenly along the plotted curve.

        Returns
        -------
        points : list of [float, float]
        """
        least = self.false_positive_rate[self.false_positive_rate > 0].min(initial=1.0)
        decades = np.log10(np.maximum(self.false_positive_rate, least))
        return _thinned(self.false_positive_rate, self.true_positive_rate, decades, most)


@dataclass(frozen=True, eq=False)
class PrecisionRecall:
    """Precision against recall.

    Attributes
    ----------
    recall, precision : (t,) array
        Recall ascending, one point for each distinct distance that is taken as the threshold.
    """

    recall: FloatArray
    precision: FloatArray

    def points(self, most: int = 200) -> list[list[float]]:
        """List [recall, precision] for a plot, with at most `most` points."""
        return _thinned(self.recall, self.precision, self.recall, most)


@dataclass(frozen=True)
class CategoryScores:
    """Scores of the Princeton Shape Benchmark (Shilane et al. 2004), each 0 … 1.

    Attributes
    ----------
    nearest_neighbor : float
        Share of queries whose first answer is of their class.
    first_tier, second_tier : float
        Share of a query's class, of C members, among the first C − 1, or 2 (C − 1), answers.
    discounted_cumulative_gain : float
        Like a recall, but later answers count less: 1 for the first, 1 / log₂ i for the i-th; 1 for a
        perfect order.
    """

    nearest_neighbor: float
    first_tier: float
    second_tier: float
    discounted_cumulative_gain: float


def ranks(distances: ArrayLike, relevant: ArrayLike) -> FloatArray:
    """Compute the rank of the relevant shape of each query.

    Parameters
    ----------
    distances : (q, d) array_like
        From every query to every database shape; infinite for shapes that are last.
    relevant : (q,) array_like of int
        Column of the shape that each query should find.

    Returns
    -------
    ranks : (q,) array
        1 is the first. Shapes at the same distance share the mean of their ranks, so a search with equal
        distances to all shapes has the middle rank, (d + 1) / 2.

    Raises
    ------
    ValueError
        If the arrays do not fit each other, or a distance is NaN.
    """
    matrix, columns = _distance_matrix(distances), np.asarray(relevant)
    if columns.shape != matrix.shape[:1] or columns.dtype.kind not in "iu":
        raise ValueError(
            f"relevant must name one column for each of the {len(matrix)} queries, not an array of shape "
            f"{columns.shape} and type {columns.dtype}"
        )
    if columns.size and not (columns.min() >= 0 and columns.max() < matrix.shape[1]):
        raise ValueError(f"relevant must lie in 0 … {matrix.shape[1] - 1}, the columns of the distances")
    own = np.take_along_axis(matrix, columns[:, None], axis=1)
    nearer, equal = (matrix < own).sum(axis=1), (matrix == own).sum(axis=1)
    places: FloatArray = nearer + (equal + 1) / 2
    return places


def strength_table(
    ranks: ArrayLike, transformations: Sequence[str], strengths: Sequence[int]
) -> dict[str, list[float]]:
    """Compute the mean average precision of each class up to each strength (paper, section 6.1).

    A query has one relevant shape, so its average precision is the reciprocal of its rank.

    Parameters
    ----------
    ranks : (q,) array_like
        Of the queries, at least 1; infinite for a shape that was not found at all.
    transformations : sequence of str
        Class of each query.
    strengths : sequence of int
        Strength of each query, 1 … 5.

    Returns
    -------
    table : dict of str to list of 5 floats
        Mean reciprocal rank × 100 over the queries of strength ≤ 1 … 5 of each class with queries, in the
        order of `CLASSES`; NaN below the least strength with queries. The last row "average" is the mean of
        the classes with queries up to this strength, all with equal weight.

    Raises
    ------
    ValueError
        If there are no queries, the lengths differ, or a rank or strength is out of range.
    """
    places = np.asarray(ranks, float)
    if not len(places) == len(transformations) == len(strengths) or places.ndim != 1:
        raise ValueError(
            f"there must be one rank, transformation and strength for each query, not {len(places)}, "
            f"{len(transformations)} and {len(strengths)}"
        )
    if len(places) == 0:
        raise ValueError("no query was asked, so there is nothing to average")
    if not (places >= 1).all():
        raise ValueError("ranks count from 1")
    if not set(strengths) <= set(STRENGTHS):
        raise ValueError(f"strengths must be 1 … 5, not {sorted(set(strengths) - set(STRENGTHS))}")
    if AVERAGE in transformations:
        raise ValueError(f"a transformation cannot be called {AVERAGE!r}")
    asked = dict.fromkeys(transformations)
    order = [name for name in CLASSES if name in asked] + [name for name in asked if name not in CLASSES]
    precision, kinds, steps = 100 / places, np.array(transformations), np.array(strengths)
    table = {
        kind: [_mean(precision[(kinds == kind) & (steps <= strength)]) for strength in STRENGTHS]
        for kind in order
    }
    columns = np.array(list(table.values())).T
    table[AVERAGE] = [_mean(column[~np.isnan(column)]) for column in columns]
    return table


def roc(distances: ArrayLike, relevant_mask: ArrayLike) -> Roc:
    """Compute the ROC of separating related from unrelated pairs by one threshold for all queries.

    Parameters
    ----------
    distances : (…) array_like
        Of any shape, for example from every query to every database shape; may be infinite.
    relevant_mask : (…) array_like of bool
        Of the same shape: which pairs are versions of one shape.

    Returns
    -------
    roc : Roc

    Raises
    ------
    ValueError
        If the shapes differ, a distance is NaN, or not both kinds of pairs occur.
    """
    accepted, right = _accepted(distances, relevant_mask)
    related, unrelated = right[-1], accepted[-1] - right[-1]
    false_positive = np.concatenate([[0.0], (accepted - right) / unrelated])
    true_positive = np.concatenate([[0.0], right / related])
    # 1 − TPR − FPR falls from 1 to −1; between two thresholds both rates are taken to be linear.
    excess = 1 - true_positive - false_positive
    after = int(np.argmax(excess <= 0))
    share = excess[after - 1] / (excess[after - 1] - excess[after])
    equal_error = false_positive[after - 1] + share * (false_positive[after] - false_positive[after - 1])
    return Roc(false_positive, true_positive, float(equal_error))


def precision_recall(distances: ArrayLike, relevant_mask: ArrayLike) -> PrecisionRecall:
    """Compute precision against recall of all pairs together, with one threshold for all queries.

    For a single query with one relevant shape the curve would be a point; for all queries together it shows
    how reliable a distance is without knowledge of the query.

    Parameters
    ----------
    distances, relevant_mask
        As for `roc`.

    Returns
    -------
    curve : PrecisionRecall

    Raises
    ------
    ValueError
        As `roc`.
    """
    accepted, right = _accepted(distances, relevant_mask)
    return PrecisionRecall(right / right[-1], right / accepted)


def category_scores(distances: ArrayLike, labels: Sequence[str]) -> CategoryScores:
    """Score a labelled collection in which every shape queries for the others of its class.

    The only member of a class is no query, but can be a match of others. Scores are means over the queries,
    and expectations over all orders of matches at equal distances. The discounted gain is divided by that of
    a perfect order of the C − 1 others of the class.

    Parameters
    ----------
    distances : (n, n) array_like
        From the shape of the row to the shape of the column; the diagonal does not matter.
    labels : sequence of n str
        Class of each shape.

    Returns
    -------
    scores : CategoryScores

    Raises
    ------
    ValueError
        If the shapes do not fit, a distance is NaN, or no class has two members.
    """
    matrix, count = np.array(_distance_matrix(distances)), len(labels)
    if matrix.shape != (count, count):
        raise ValueError(f"{count} labels need distances of shape ({count}, {count}), not {matrix.shape}")
    names = np.array(labels)
    same = names[:, None] == names
    np.fill_diagonal(same, False)
    others = same.sum(axis=1)
    if not others.any():
        raise ValueError("no class has two members, so there is nothing to find")
    discount = 1 / np.maximum(np.log2(np.maximum(np.arange(1, count), 1)), 1)
    scores = []
    for query in np.flatnonzero(others):
        answers = np.delete(np.arange(count), query)
        gains = _expected_gains(matrix[query, answers], same[query, answers])
        wanted = others[query]
        scores.append(
            [
                gains[0],
                gains[:wanted].sum() / wanted,
                gains[: 2 * wanted].sum() / wanted,
                gains @ discount / discount[:wanted].sum(),
            ]
        )
    return CategoryScores(*(float(score) for score in np.mean(scores, axis=0)))


def _distance_matrix(distances: ArrayLike) -> FloatArray:
    matrix = np.asarray(distances, float)
    if matrix.ndim != 2:
        raise ValueError(
            f"distances must be a matrix, queries by database shapes, not of shape {matrix.shape}"
        )
    if np.isnan(matrix).any():
        raise ValueError(f"{int(np.isnan(matrix).sum())} of {matrix.size} distances are NaN")
    return matrix


def _mean(values: FloatArray) -> float:
    return float(values.mean()) if len(values) else float("nan")


def _accepted(distances: ArrayLike, relevant_mask: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Count the pairs that each threshold accepts, and the related ones among them, (t,) each."""
    values, related = np.asarray(distances, float), np.asarray(relevant_mask)
    if values.shape != related.shape or related.dtype != bool:
        raise ValueError(
            f"relevant_mask must hold a bool for each distance, shape {values.shape}, not {related.dtype} of "
            f"shape {related.shape}"
        )
    if np.isnan(values).any():
        raise ValueError(f"{int(np.isnan(values).sum())} of {values.size} distances are NaN")
    if not related.any() or related.all():
        raise ValueError("both related and unrelated pairs are needed to tell them apart")
    _, threshold = np.unique(values.ravel(), return_inverse=True)
    accepted = np.cumsum(np.bincount(threshold)).astype(float)
    right = np.cumsum(np.bincount(threshold, related.ravel())).astype(float)
    return accepted, right


def _thinned(x: FloatArray, y: FloatArray, seen_x: FloatArray, most: int) -> list[list[float]]:
    """Choose points at even distances along a curve as plotted over `seen_x`; both ends are kept."""
    if len(x) > most:
        wide = max(float(np.ptp(seen_x)), np.finfo(float).tiny)
        steps = np.hypot(np.diff(seen_x) / wide, np.diff(y))
        along = np.concatenate([[0.0], np.cumsum(steps)])
        kept = np.unique(np.searchsorted(along, np.linspace(0, along[-1], most)).clip(0, len(x) - 1))
        kept[-1] = len(x) - 1
        x, y = x[kept], y[kept]
    return [[float(a), float(b)] for a, b in zip(x, y, strict=True)]


def _expected_gains(distances: FloatArray, right: BoolArray) -> FloatArray:
    """Compute the probability that the match of each rank is right, for random orders of ties, (n,)."""
    order = np.argsort(distances, kind="stable")
    _, group, sizes = np.unique(distances[order], return_inverse=True, return_counts=True)
    gains: FloatArray = (np.bincount(group, right[order]) / sizes)[group]
    return gains
