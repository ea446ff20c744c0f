# SPDX-License-Identifier: MIT
"""Inverse document frequency, against the equation."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.words import (
    InverseDocumentFrequency,
)


def test_inverse_document_frequency_is_equation_17() -> None:
    bags = np.array([[0.5, 0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.3, 0.3, 0.4, 0.0]])
    weighting = InverseDocumentFrequency().fit(bags)
    np.testing.assert_allclose(weighting.weights_, np.log([3 / 3, 3 / 2, 3 / 1, 3 / 1]))
    np.testing.assert_allclose(weighting.transform(bags), bags * weighting.weights_)


def test_inverse_document_frequency_of_pairs_with_soft_words() -> None:
    bags = np.array([[0.98, 0.01, 0.01], [0.50, 0.49, 0.01]])
    assert (InverseDocumentFrequency().fit(bags).weights_ == 0).all()
    np.testing.assert_allclose(InverseDocumentFrequency(0.1).fit(bags).weights_, np.log([1, 2, 2]))
