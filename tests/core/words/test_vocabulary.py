# SPDX-License-Identifier: MIT
"""Vocabulary: words of blobs, outliers and descriptors that equal their word."""

from __future__ import annotations

import numpy as np
import pytest

from shapegoogle_core.words import (
    Vocabulary,
    hard_words,
)
from tests.core.words.blobs import blobs


def test_vocabulary_finds_the_centres() -> None:
    vocabulary = Vocabulary(3).fit(blobs())
    np.testing.assert_allclose(np.sort(vocabulary.centers_, axis=0), [[0, 0], [0, 0], [5, 5]], atol=0.05)
    nearest = hard_words(blobs(), vocabulary.centers_).argmax(axis=1)
    distances = np.linalg.norm(blobs() - vocabulary.centers_[nearest], axis=1)
    assert vocabulary.sigma_ == pytest.approx(2 * np.median(distances), rel=0.03)


def test_outliers_do_not_pull_the_words() -> None:
    # Far points of less than the share that is left out would take a word for themselves otherwise.
    words = Vocabulary(4, outlier_share=0.01).fit(blobs(outliers=5)).centers_
    assert words.max() < 10
    assert Vocabulary(4, outlier_share=0.0).fit(blobs(outliers=5)).centers_.max() > 10


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_descriptors_that_equal_their_words_are_quantised_hard(scale: float) -> None:
    """A sphere beside a few other shapes: most descriptors are the same, in any unit."""
    points = scale * np.repeat([[0.0, 0.0], [0.18, 0.0], [0.0, 0.18]], 50, axis=0)
    vocabulary = Vocabulary(3).fit(points)
    np.testing.assert_allclose(vocabulary.transform(points).max(axis=1), 1.0)


def test_vocabulary_is_reproducible() -> None:
    first, second = (Vocabulary(8, random_state=3).fit(blobs()).centers_ for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(
    ("parameter", "value"), [("words", 0), ("restarts", 0), ("sigma_factor", -1.0), ("outlier_share", 2)]
)
def test_parameters_out_of_range_are_named(parameter: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{parameter} must be a .*number"):
        Vocabulary().set_params(**{parameter: value}).fit(blobs())
