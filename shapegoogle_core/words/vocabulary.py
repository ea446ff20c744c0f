# SPDX-License-Identifier: MIT
"""Vocabulary of geometric words, learnt by k-means (paper, section 4)."""

from __future__ import annotations

from typing import Self

import numpy as np
from sklearn.base import BaseEstimator, TransformerMixin

from shapegoogle_core.api.arguments import check_count, check_number
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.words.assignment import hard_words, soft_words
from shapegoogle_core.words.estimators import check_features, learn_features

__all__ = ["Vocabulary"]


class Vocabulary(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Geometric vocabulary: k-means centres of descriptors (paper, section 4).

    Parameters
    ----------
    words : int
        V, the number of words.
    soft : bool
        Whether `transform` returns distributions over the words (equation 12) or only the nearest word.
    sigma_factor : float
        σ as a multiple of the median distance of a training descriptor to its nearest word.
    outlier_share : float
        Share of the training descriptors, those farthest from their words, that a second run of k-means
        leaves out.
    restarts : int
        Number of random starts of k-means; the one with the least inertia is kept.
    random_state : int, RandomState or None
        Seed or generator of k-means.

    Attributes
    ----------
    centers_ : (V, d) array
        Words, sorted by their first component, so that their numbers depend less on the random start.
    sigma_ : float
        σ of equation 12, in the unit of the descriptors.
    n_features_in_ : int
        d, the length of the descriptors.

    See Also
    --------
    soft_words, hard_words : The two kinds of assignment.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> descriptors = np.array([[0.0], [0.1], [0.2], [5.0], [5.1], [5.2]])
    >>> vocabulary = sg.Vocabulary(words=2, outlier_share=0.0).fit(descriptors)
    >>> vocabulary.centers_.round(3).tolist()
    [[0.1], [5.1]]
    >>> vocabulary.transform([[0.0], [5.2]]).round(3).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """

    def __init__(
        self,
        words: int = 48,
        *,
        soft: bool = True,
        sigma_factor: float = 2.0,
        outlier_share: float = 0.01,
        restarts: int = 5,
        random_state: int | np.random.RandomState | None = 0,
    ) -> None:
        self.words = words
        self.soft = soft
        self.sigma_factor = sigma_factor
        self.outlier_share = outlier_share
        self.restarts = restarts
        self.random_state = random_state

    def fit(self, X: FloatArray, y: object = None) -> Self:  # noqa: ARG002 (scikit-learn's signature)
        """Learn the words.

        Parameters
        ----------
        X : (n, d) array
            Training descriptors.
        y : ignored

        Returns
        -------
        self : Vocabulary

        Raises
        ------
        ValueError
            If a parameter is out of range, there are fewer descriptors than words, or X is not a finite
            array.
        """
        from sklearn.cluster import KMeans  # slow to import, and only needed here

        check_count("words", self.words)
        check_count("restarts", self.restarts)
        check_number("sigma_factor", self.sigma_factor)
        check_number("outlier_share", self.outlier_share, most=1)
        descriptors = learn_features(self, X, min_samples=self.words)
        kmeans = KMeans(self.words, n_init=self.restarts, max_iter=250, random_state=self.random_state)
        kmeans.fit(descriptors)
        distances = kmeans.transform(descriptors).min(axis=1)
        inliers = distances <= np.quantile(distances, 1 - self.outlier_share)
        if self.outlier_share > 0 and inliers.sum() >= self.words:
            kmeans.fit(descriptors[inliers])
            distances = kmeans.transform(descriptors[inliers]).min(axis=1)
        order = np.lexsort(kmeans.cluster_centers_.T[::-1])
        self.centers_ = kmeans.cluster_centers_[order]
        # If most descriptors equal their word, the median is 0. A small σ, relative to the spread of the
        # descriptors, then gives a hard assignment without a division by zero.
        spread = float(np.sqrt(descriptors.var(axis=0).sum()))
        self.sigma_ = max(self.sigma_factor * float(np.median(distances)), 1e-6 * spread) or 1.0
        return self

    def transform(self, X: FloatArray) -> FloatArray:
        """Express descriptors in words.

        Parameters
        ----------
        X : (n, d) array
            Descriptors.

        Returns
        -------
        words : (n, V) array
            θ(x), rows sum to 1.

        Raises
        ------
        NotFittedError
            If the estimator was not fitted.
        ValueError
            If X is not finite or its descriptors have another length than those of `fit`.
        """
        descriptors = check_features(self, X)
        if self.soft:
            return soft_words(descriptors, self.centers_, self.sigma_)
        return hard_words(descriptors, self.centers_)
