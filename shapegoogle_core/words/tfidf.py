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
    """Weights that give more importance to words found on few shapes (paper, equations 17 and 18).

    w_i = log(D / #{shapes that contain word i})

    The L1 distance between transformed bags is the weighted distance of equation 18. Spatially sensitive bags
    are passed as rows of length V²; pairs of words then take the place of words.

    Parameters
    ----------
    threshold : float
        A shape contains a word if the word's share of its bag exceeds this. 0 is the paper's definition, and
        right for bags of hard words. With soft words every word occurs everywhere and all weights would be 0:
        fit to bags of hard words, or set a threshold.

    Attributes
    ----------
    weights_ : (V,) array
        w ≥ 0. A word that no training shape contains gets log(D), as if one did.
    n_features_in_ : int
        V, the number of words.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> bags = np.array([[0.5, 0.5, 0.0], [1.0, 0.0, 0.0], [0.4, 0.0, 0.6]])
    >>> weighting = sg.InverseDocumentFrequency().fit(bags)
    >>> weighting.weights_.round(3).tolist()
    [0.0, 1.099, 1.099]
    >>> weighting.transform(bags)[0].round(3).tolist()
    [0.0, 0.549, 0.0]
    """

    def __init__(self, threshold: float = 0.0) -> None:
        self.threshold = threshold

    def fit(self, X: FloatArray, y: object = None) -> Self:  # noqa: ARG002 (scikit-learn's signature)
        """Count the shapes in which each word occurs.

        Parameters
        ----------
        X : (D, V) array
            Bags of the training shapes.
        y : ignored

        Returns
        -------
        self : InverseDocumentFrequency

        Raises
        ------
        ValueError
            If X is not a finite array.
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

        Raises
        ------
        NotFittedError
            If the estimator was not fitted.
        ValueError
            If X is not finite or has another number of words than the bags of `fit`.
        """
        return np.asarray(check_features(self, X) * self.weights_)
