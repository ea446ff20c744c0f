# SPDX-License-Identifier: MIT
"""Term frequency – inverse document frequency (paper, section 4.2)."""

from __future__ import annotations

from typing import Self

import numpy as np
from sklearn.base import BaseEstimator, OneToOneFeatureMixin, TransformerMixin

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.words.estimators import check_features, learn_features

__all__ = ["InverseDocumentFrequency"]


class InverseDocumentFrequency(OneToOneFeatureMixin, TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Weights that make words found on few shapes count more (paper, equations 17 and 18).

    w_i = log(D / #{shapes that contain word i})

    The L1 distance between transformed bags is the weighted distance of equation 18. Pairs of words are
    words here: pass spatially sensitive bags as rows of length V².

    Parameters
    ----------
    threshold : float
        A shape contains a word when its bag holds more than this share of it. 0 is the paper's definition,
        and right for bags of hard words. With soft words every word occurs everywhere and all weights would
        be 0: count on hard bags, or set a threshold.

    Attributes
    ----------
    weights_ : (V,) array
        ≥ 0. A word that no training shape contains gets log(D), as if one did.
    """

    def __init__(self, threshold: float = 0.0) -> None:
        self.threshold = threshold

    def fit(self, X: FloatArray, y: object = None) -> Self:  # noqa: ARG002 (scikit-learn's signature)
        """Count in how many shapes each word occurs.

        Parameters
        ----------
        X : (D, V) array
            Bags.
        y : ignored

        Returns
        -------
        self : InverseDocumentFrequency
        """
        bags = learn_features(self, X)
        shapes_with_word = (bags > self.threshold).sum(axis=0)
        self.weights_ = np.log(len(bags) / np.maximum(shapes_with_word, 1))
        return self

    def transform(self, X: FloatArray) -> FloatArray:
        """Multiply every frequency by its word's weight.

        Parameters
        ----------
        X : (n, V) array
            Bags, soft or hard.

        Returns
        -------
        weighted : (n, V) array
        """
        weighted: FloatArray = check_features(self, X) * self.weights_
        return weighted
