# SPDX-License-Identifier: MIT
"""Similarity-sensitive hashing: thresholds by brute force, and codes that keep similar vectors together."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.words import SimilaritySensitiveHashing, rotated_components
from shapegoogle_core.words.hashing import best_threshold


def clusters(
    shapes: int, versions: int, dimension: int, seed: int, spread: float = 1.0
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Vectors whose versions differ much along half of the axes and little along the rest."""
    random = np.random.default_rng(seed)
    scale = np.where(np.arange(dimension) < dimension // 2, 3.0 * spread, 0.1 * spread)
    centers = random.standard_normal((shapes, dimension))
    vectors = centers[:, None] + scale * random.standard_normal((shapes, versions, dimension))
    return vectors.reshape(-1, dimension), np.repeat(np.arange(shapes), versions)


def pairs(
    labels: np.ndarray, count: int, seed: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
    random = np.random.default_rng(seed)
    a, b = random.integers(len(labels), size=(2, 40 * count))
    same = (labels[a] == labels[b]) & (a != b)
    keep = np.concatenate([np.flatnonzero(same)[:count], np.flatnonzero(~same & (a != b))[:count]])
    return a[keep], b[keep], same[keep]


@settings(max_examples=100, deadline=None)
@given(
    values=arrays(np.float64, (9, 2), elements=st.integers(-5, 5).map(float)),
    weights=arrays(np.float64, 9, elements=st.floats(-1, 1)),
)
def test_threshold_is_the_best_of_all(values: FloatArray, weights: FloatArray) -> None:
    first, second = values.T
    threshold, agreement = best_threshold(first, second, weights)

    def measure(b: float) -> float:
        return float(weights @ (np.sign(first + b) * np.sign(second + b)))

    ends = np.unique(values)
    middles = -(ends[1:] + ends[:-1]) / 2
    candidates = [measure(b) for b in middles]
    if candidates:
        assert agreement == pytest.approx(max(candidates), abs=1e-9)
        assert measure(threshold) == pytest.approx(agreement, abs=1e-9)


def codes_tell_apart(hashing: SimilaritySensitiveHashing, seed: int) -> tuple[float, float]:
    vectors, labels = clusters(40, 6, 12, seed)
    bits = hashing.transform(vectors)
    a, b, same = pairs(labels, 300, seed)
    distance = (bits[a] != bits[b]).mean(axis=1)
    return float(distance[same].mean()), float(distance[~same].mean())


def test_codes_generalise_to_shapes_that_were_not_trained_on() -> None:
    vectors, labels = clusters(60, 6, 12, seed=0)
    a, b, same = pairs(labels, 1000, seed=0)
    near, far = codes_tell_apart(SimilaritySensitiveHashing(32).fit(vectors[a], vectors[b], same), seed=1)
    assert near < 0.25
    assert far > 0.4
    # Random projections do not know along which axes versions differ.
    random = SimilaritySensitiveHashing(32, projection="random").fit(vectors[a], vectors[b], same)
    near_random, far_random = codes_tell_apart(random, seed=1)
    assert far - near > far_random - near_random


def test_bits_are_better_than_chance_and_differ() -> None:
    vectors, labels = clusters(60, 6, 12, seed=2)
    a, b, same = pairs(labels, 1000, seed=2)
    hashing = SimilaritySensitiveHashing(16).fit(vectors[a], vectors[b], same)
    random_labels = np.random.default_rng(0).permutation(same)
    chance = SimilaritySensitiveHashing(16).fit(vectors[a], vectors[b], random_labels)
    assert hashing.losses_[0] < 1
    assert hashing.losses_.mean() < 0.95 * chance.losses_.mean()
    assert chance.losses_.mean() == pytest.approx(np.cosh(1), rel=0.05)
    bits = hashing.transform(vectors)
    assert len(np.unique(bits.T, axis=0)) > 8


@settings(max_examples=10, deadline=None)
@given(exponent=st.integers(-8, 8), projection=st.sampled_from(["eigenvectors", "random"]))
def test_codes_do_not_depend_on_the_unit(exponent: int, projection: str) -> None:
    vectors, labels = clusters(20, 5, 6, seed=3)
    a, b, same = pairs(labels, 200, seed=3)
    scale = 2.0**exponent
    plain = SimilaritySensitiveHashing(8, projection=projection).fit(vectors[a], vectors[b], same)
    scaled = SimilaritySensitiveHashing(8, projection=projection).fit(
        scale * vectors[a], scale * vectors[b], same
    )
    agreement = (plain.transform(vectors) == scaled.transform(scale * vectors)).mean()
    assert agreement > 0.99


def test_same_input_same_codes() -> None:
    vectors, labels = clusters(20, 5, 6, seed=4)
    a, b, same = pairs(labels, 200, seed=4)
    first, second = (
        SimilaritySensitiveHashing(8, projection="random", random_state=5).fit(vectors[a], vectors[b], same)
        for _ in range(2)
    )
    np.testing.assert_array_equal(first.transform(vectors), second.transform(vectors))


def test_positive_pairs_that_are_equal() -> None:
    """Undisturbed shapes are their own positive pairs: the covariance of the positives is zero."""
    vectors = np.random.default_rng(6).standard_normal((50, 4))
    other = np.roll(vectors, 1, axis=0)
    hashing = SimilaritySensitiveHashing(8).fit(
        np.concatenate([vectors, vectors]), np.concatenate([vectors, other]), np.arange(100) < 50
    )
    assert np.isfinite(hashing.directions_).all()


def test_bad_input() -> None:
    vectors = np.ones((4, 3))
    with pytest.raises(ValueError, match="positive and negative"):
        SimilaritySensitiveHashing().fit(vectors, vectors, np.ones(4, bool))
    with pytest.raises(ValueError, match=r"second \(3, 3\)"):
        SimilaritySensitiveHashing().fit(vectors, vectors[:3], np.ones(4, bool))
    with pytest.raises(ValueError, match="projection must be"):
        SimilaritySensitiveHashing(projection="best").fit(vectors, vectors, np.arange(4) < 2)
    fitted = SimilaritySensitiveHashing(4).fit(
        np.random.default_rng(0).standard_normal((8, 3)),
        np.random.default_rng(1).standard_normal((8, 3)),
        np.arange(8) < 4,
    )
    with pytest.raises(ValueError, match="5 features"):
        fitted.transform(np.ones((2, 5)))


def test_rotated_components_are_orthonormal_and_within_the_leading_ones() -> None:
    random = np.random.default_rng(0)
    axes, _ = np.linalg.qr(random.standard_normal((20, 20)))
    vectors = random.standard_normal((500, 20)) * np.where(np.arange(20) < 8, 5.0, 0.1) @ axes.T
    directions = rotated_components(vectors, bits=8)
    np.testing.assert_allclose(directions @ directions.T, np.eye(8), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(directions @ axes[:, :8], axis=1), 1, atol=1e-3)
    assert rotated_components(vectors, bits=50).shape == (50, 20)
