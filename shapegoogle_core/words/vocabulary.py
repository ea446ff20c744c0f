# SPDX-License-Identifier: MIT
"""Learning a vocabulary of geometric words (paper, section 4).

Apart from `words.py`, so that describing a shape does not import scikit-learn.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from sklearn.base import BaseEstimator, TransformerMixin

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
        Whether `transform` gives distributions over the words (equation 12) or the nearest word only.
    sigma_factor : float
        σ as a multiple of the median distance of a training descriptor to its nearest word.
    outlier_share : float
        Share of the training descriptors, the farthest from their words, that a second round of k-means
        leaves out.
    restarts : int
        How many random starts k-means has; the one with the least inertia is kept.
    random_state : int, RandomState or None
        Of k-means.

    Attributes
    ----------
    centers_ : (V, d) array
        Sorted by their first component, so that the numbering does not depend on the random start alone.
    sigma_ : float
        In the unit of the descriptors.
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
            If there are fewer descriptors than words.
        """
        from sklearn.cluster import KMeans  # half a second to import, and only training needs it

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
        # Where most descriptors equal their word, a σ of 0 would divide by zero: a small one, relative to
        # the spread of the descriptors, gives the hard assignment that it stands for.
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
        """
        descriptors = check_features(self, X)
        if self.soft:
            return soft_words(descriptors, self.centers_, self.sigma_)
        return hard_words(descriptors, self.centers_)
