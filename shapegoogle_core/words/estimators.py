# SPDX-License-Identifier: MIT
"""Input checks of the estimators, in the form that the conventions of scikit-learn require."""

from __future__ import annotations

from typing import Any

import numpy as np
from sklearn.base import BaseEstimator
from sklearn.utils.validation import check_array, check_is_fitted

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["check_features", "learn_features"]


def learn_features(estimator: BaseEstimator, X: Any, min_samples: int = 1) -> FloatArray:
    """Check a training array and record its number of features.

    Parameters
    ----------
    estimator : BaseEstimator
        Its attribute `n_features_in_` is set.
    X : (n, d) array_like
        Training samples.
    min_samples : int
        Least number of samples.

    Returns
    -------
    X : (n, d) array of float64

    Raises
    ------
    ValueError
        If X is not a finite array of at least that number of rows.
    """
    array: FloatArray = check_array(X, dtype=np.float64, ensure_min_samples=min_samples, estimator=estimator)
    estimator.n_features_in_ = array.shape[1]
    return array


def check_features(estimator: BaseEstimator, X: Any) -> FloatArray:
    """Check that an array has as many features as those that the estimator was fitted to.

    Parameters
    ----------
    estimator : BaseEstimator
        A fitted estimator, with `n_features_in_`.
    X : (n, d) array_like
        Samples.

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
