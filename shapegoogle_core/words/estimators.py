# SPDX-License-Identifier: MIT
"""Input checks that the estimators share, in the form scikit-learn's own conventions ask for."""

from __future__ import annotations

from typing import Any

import numpy as np
from sklearn.base import BaseEstimator
from sklearn.utils.validation import check_array, check_is_fitted

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["check_features", "learn_features"]


def learn_features(estimator: BaseEstimator, X: Any, min_samples: int = 1) -> FloatArray:
    """Check a training array and remember how many features it has.

    Parameters
    ----------
    estimator : BaseEstimator
        Gets `n_features_in_`.
    X : (n, d) array_like
    min_samples : int
        The least n.

    Returns
    -------
    X : (n, d) array of float64

    Raises
    ------
    ValueError
        If X is not a finite array of that many rows.
    """
    array: FloatArray = check_array(X, dtype=np.float64, ensure_min_samples=min_samples, estimator=estimator)
    estimator.n_features_in_ = array.shape[1]
    return array


def check_features(estimator: BaseEstimator, X: Any) -> FloatArray:
    """Check an array against what the estimator was fitted with.

    Parameters
    ----------
    estimator : BaseEstimator
        Fitted, with `n_features_in_`.
    X : (n, d) array_like

    Returns
    -------
    X : (n, d) array of float64

    Raises
    ------
    NotFittedError
        If the estimator was not fitted.
    ValueError
        If X is not finite or has another number of features.
    """
    check_is_fitted(estimator)
    array: FloatArray = check_array(X, dtype=np.float64, estimator=estimator)
    expected = estimator.n_features_in_
    if array.shape[1] != expected:
        raise ValueError(
            f"X has {array.shape[1]} features, but {type(estimator).__name__} is expecting "
            f"{expected} features as input"
        )
    return array
