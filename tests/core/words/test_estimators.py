# SPDX-License-Identifier: MIT
"""The checks of scikit-learn for its own estimators."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from sklearn.base import BaseEstimator
from sklearn.utils import estimator_checks
from sklearn.utils.estimator_checks import parametrize_with_checks

from shapegoogle_core.words import (
    InverseDocumentFrequency,
    SimilaritySensitiveHashing,
    Vocabulary,
)


@parametrize_with_checks([Vocabulary(words=3), InverseDocumentFrequency()])  # type: ignore[untyped-decorator]
def test_estimators_follow_scikit_learn(
    estimator: BaseEstimator, check: Callable[[BaseEstimator], None]
) -> None:
    check(estimator)


# Those that need no fit to single samples: hashing is fitted to pairs.
PARAMETER_CHECKS = (
    "check_no_attributes_set_in_init",
    "check_parameters_default_constructible",
    "check_get_params_invariance",
    "check_set_params",
)


@pytest.mark.parametrize("name", PARAMETER_CHECKS)
def test_hashing_keeps_its_parameters_as_scikit_learn_does(name: str) -> None:
    getattr(estimator_checks, name)("SimilaritySensitiveHashing", SimilaritySensitiveHashing())
