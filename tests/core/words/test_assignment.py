# SPDX-License-Identifier: MIT
"""Soft and hard assignment to words."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.words import (
    Vocabulary,
    hard_words,
    soft_words,
)
from tests.core.words.blobs import blobs


def test_soft_words_are_equation_12() -> None:
    centers = np.array([[0.0, 0.0], [1.0, 0.0]])
    words = soft_words(np.array([[0.25, 0.0]]), centers, sigma=0.5)
    expected = np.exp([-(0.25**2) / 0.5, -(0.75**2) / 0.5])
    np.testing.assert_allclose(words[0], expected / expected.sum())


@settings(max_examples=50, deadline=None)
@given(
    points=arrays(np.float64, (6, 3), elements=st.floats(-1e6, 1e6)),
    centers=arrays(np.float64, (4, 3), elements=st.floats(-1e6, 1e6)),
    sigma=st.floats(1e-6, 1e6),
)
def test_words_are_distributions(points: FloatArray, centers: FloatArray, sigma: float) -> None:
    for words in (soft_words(points, centers, sigma), hard_words(points, centers)):
        assert (words >= 0).all()
        np.testing.assert_allclose(words.sum(axis=1), 1)


def test_soft_words_become_hard() -> None:
    points, centers = blobs(), Vocabulary(3).fit(blobs()).centers_
    np.testing.assert_allclose(soft_words(points, centers, 1e-3), hard_words(points, centers), atol=1e-12)


def test_what_does_not_fit_is_refused() -> None:
    points = np.zeros((4, 3))
    for sigma in (0, -1.0, np.nan):
        with pytest.raises(ValueError, match="sigma must be a positive number"):
            soft_words(points, points, sigma)
    with pytest.raises(ValueError, match="descriptors of 3 values do not fit 4 words of 2"):
        hard_words(points, points[:, :2])
    with pytest.raises(ValueError, match="do not fit 0 words"):
        hard_words(points, points[:0])
    with pytest.raises(ValueError, match="descriptors must be numbers in rows and columns"):
        soft_words(points[0], points, 1.0)
