# SPDX-License-Identifier: MIT
"""The measures of published benchmarks: those of PSB, and the mean average precision that SHREC adds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.protocol.metrics import CategoryScores, category_scores

__all__ = ["PublishedScores", "published_scores"]

E_MEASURE_LENGTH = 32
"""Matches that the E-measure looks at, as many as a page of pictures shows."""


@dataclass(frozen=True)
class PublishedScores:
    """Scores of a labelled collection, each from 0 to 1.

    Attributes
    ----------
    category : CategoryScores
        Nearest neighbour, first and second tier, and discounted cumulative gain.
    e_measure : float
        Harmonic mean of precision and recall of the first 32 matches.
    mean_average_precision : float
        Mean over the queries of the mean precision at each member of their class.
    """

    category: CategoryScores
    e_measure: float
    mean_average_precision: float

    def percent(self) -> dict[str, float]:
        """List the scores in percent by their usual abbreviations."""
        scores = {
            "NN": self.category.nearest_neighbor,
            "FT": self.category.first_tier,
            "ST": self.category.second_tier,
            "E": self.e_measure,
            "DCG": self.category.discounted_cumulative_gain,
            "mAP": self.mean_average_precision,
        }
        return {name: round(100 * score, 1) for name, score in scores.items()}


def published_scores(distances: ArrayLike, labels: Sequence[str]) -> PublishedScores:
    """Score a collection in which every shape queries for the others of its class.

    The query itself is no match. The only member of a class is not a query, but can be a match. Scores are
    means over the queries, which PSB calls micro-averaged. At equal distances the order of the collection
    decides for the E-measure and the average precision, and all orders are averaged for the other scores.

    Parameters
    ----------
    distances : (n, n) array_like
        From the shape of the row to the shape of the column; the diagonal does not matter.
    labels : sequence of n str

    Returns
    -------
    scores : PublishedScores

    Raises
    ------
    ValueError
        As `category_scores`.

    Examples
    --------
    >>> scores = published_scores([[0, 1, 2], [1, 0, 2], [2, 1, 0]], ["cat", "cat", "dog"])
    >>> scores.mean_average_precision
    1.0
    """
    category = category_scores(distances, labels)
    matrix, names = np.asarray(distances, float), np.array(labels)
    length = min(E_MEASURE_LENGTH, len(names) - 1)
    e_measures, precisions = [], []
    for query, name in enumerate(names):
        answers = np.delete(np.arange(len(names)), query)
        right = names[answers[np.argsort(matrix[query, answers], kind="stable")]] == name
        wanted = int(right.sum())
        if not wanted:
            continue
        found = int(right[:length].sum())
        # 2 / (1 / precision + 1 / recall)
        e_measures.append(2 * found / (length + wanted))
        places = np.flatnonzero(right) + 1
        precisions.append(float(np.mean(np.arange(1, wanted + 1) / places)))
    return PublishedScores(category, float(np.mean(e_measures)), float(np.mean(precisions)))
