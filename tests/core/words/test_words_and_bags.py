# SPDX-License-Identifier: MIT
"""Vocabulary, bags and tf-idf: the equations on small numbers, and scikit-learn's own checks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from sklearn.utils.estimator_checks import parametrize_with_checks

from shapegoogle_core.spectral import compute_spectrum
from shapegoogle_core.words import (
    InverseDocumentFrequency,
    Vocabulary,
    bag_of_features,
    hard_words,
    soft_words,
    spatially_sensitive_bag,
)


@parametrize_with_checks([Vocabulary(words=3), InverseDocumentFrequency()])
def test_estimators_follow_scikit_learn(estimator, check):
    check(estimator)


def blobs(seed: int = 0, outliers: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed)
    points = [center + 0.1 * random.standard_normal((200, 2)) for center in ([0, 0], [5, 0], [0, 5])]
    return np.concatenate([*points, random.uniform(50, 100, (outliers, 2))])


def test_vocabulary_finds_the_centres():
    vocabulary = Vocabulary(3).fit(blobs())
    np.testing.assert_allclose(np.sort(vocabulary.centers_, axis=0), [[0, 0], [0, 0], [5, 5]], atol=0.05)
    nearest = hard_words(blobs(), vocabulary.centers_).argmax(axis=1)
    distances = np.linalg.norm(blobs() - vocabulary.centers_[nearest], axis=1)
    assert vocabulary.sigma_ == pytest.approx(2 * np.median(distances), rel=0.03)


def test_outliers_do_not_pull_the_words():
    # Far points of less than the share that is left out would take a word for themselves otherwise.
    words = Vocabulary(4, outlier_share=0.01).fit(blobs(outliers=5)).centers_
    assert words.max() < 10
    assert Vocabulary(4, outlier_share=0.0).fit(blobs(outliers=5)).centers_.max() > 10


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_descriptors_that_equal_their_words_are_quantised_hard(scale):
    """A sphere beside a few other shapes: most descriptors are the same, in any unit."""
    points = scale * np.repeat([[0.0, 0.0], [0.18, 0.0], [0.0, 0.18]], 50, axis=0)
    vocabulary = Vocabulary(3).fit(points)
    np.testing.assert_allclose(vocabulary.transform(points).max(axis=1), 1.0)


def test_vocabulary_is_reproducible():
    first, second = (Vocabulary(8, random_state=3).fit(blobs()).centers_ for _ in range(2))
    np.testing.assert_array_equal(first, second)


def test_soft_words_are_equation_12():
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
def test_words_are_distributions(points, centers, sigma):
    for words in (soft_words(points, centers, sigma), hard_words(points, centers)):
        assert (words >= 0).all()
        np.testing.assert_allclose(words.sum(axis=1), 1)


def test_soft_words_become_hard():
    points, centers = blobs(), Vocabulary(3).fit(blobs()).centers_
    np.testing.assert_allclose(soft_words(points, centers, 1e-3), hard_words(points, centers), atol=1e-12)


def test_bag_is_equation_13():
    words = np.array([[1.0, 0.0], [0.5, 0.5]])
    np.testing.assert_allclose(bag_of_features(words, np.array([3.0, 1.0])), [0.875, 0.125])
    np.testing.assert_allclose(bag_of_features(words), [0.75, 0.25])


@pytest.mark.parametrize("area_weighted", [True, False])
def test_spatially_sensitive_bag_is_the_double_integral(bumpy, area_weighted):
    spectrum = compute_spectrum(bumpy, 50)
    random = np.random.default_rng(0)
    words = random.dirichlet(np.ones(5), len(bumpy.vertices))
    time = 0.3
    kernel = (spectrum.eigenvectors * np.exp(-spectrum.eigenvalues * time)) @ spectrum.eigenvectors.T
    weights = spectrum.mass if area_weighted else np.ones(len(spectrum.mass))
    expected = (weights[:, None] * words).T @ kernel @ (weights[:, None] * words)
    bag = spatially_sensitive_bag(words, spectrum, time, area_weighted=area_weighted)
    np.testing.assert_allclose(bag, expected / expected.sum(), atol=1e-12)
    np.testing.assert_allclose(bag, bag.T, atol=1e-15)


def test_pair_bag_sums_to_the_plain_bag(bumpy):
    """Heat is conserved, so integrating over y leaves the bag of features: F 1 = f."""
    spectrum = compute_spectrum(bumpy, 50)
    words = np.random.default_rng(1).dirichlet(np.ones(6), len(bumpy.vertices))
    bag = spatially_sensitive_bag(words, spectrum, 0.2)
    np.testing.assert_allclose(bag.sum(axis=1), bag_of_features(words, spectrum.mass), rtol=1e-6)


def test_pair_bag_at_late_times_forgets_the_places(bumpy):
    spectrum = compute_spectrum(bumpy, 50)
    words = np.random.default_rng(2).dirichlet(np.ones(4), len(bumpy.vertices))
    plain = bag_of_features(words, spectrum.mass)
    late = spatially_sensitive_bag(words, spectrum, 1e3 / spectrum.eigenvalues[1])
    np.testing.assert_allclose(late, np.outer(plain, plain), rtol=1e-6)


def test_inverse_document_frequency_is_equation_17():
    bags = np.array([[0.5, 0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.3, 0.3, 0.4, 0.0]])
    weighting = InverseDocumentFrequency().fit(bags)
    np.testing.assert_allclose(weighting.weights_, np.log([3 / 3, 3 / 2, 3 / 1, 3 / 1]))
    np.testing.assert_allclose(weighting.transform(bags), bags * weighting.weights_)


def test_inverse_document_frequency_of_pairs_with_soft_words():
    bags = np.array([[0.98, 0.01, 0.01], [0.50, 0.49, 0.01]])
    assert (InverseDocumentFrequency().fit(bags).weights_ == 0).all()
    np.testing.assert_allclose(InverseDocumentFrequency(0.1).fit(bags).weights_, np.log([1, 2, 2]))
