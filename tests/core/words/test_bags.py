# SPDX-License-Identifier: MIT
"""Bags of words and of pairs of words, against the equations."""

from __future__ import annotations

import numpy as np
import pytest

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.spectral import compute_spectrum
from shapegoogle_core.words import (
    bag_of_features,
    spatially_sensitive_bag,
)


def test_bag_is_equation_13() -> None:
    words = np.array([[1.0, 0.0], [0.5, 0.5]])
    np.testing.assert_allclose(bag_of_features(words, np.array([3.0, 1.0])), [0.875, 0.125])
    np.testing.assert_allclose(bag_of_features(words), [0.75, 0.25])


@pytest.mark.parametrize("area_weighted", [True, False])
def test_spatially_sensitive_bag_is_the_double_integral(bumpy: Mesh, area_weighted: bool) -> None:
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


def test_pair_bag_sums_to_the_plain_bag(bumpy: Mesh) -> None:
    """Heat is conserved, so integrating over y leaves the bag of features: F 1 = f."""
    spectrum = compute_spectrum(bumpy, 50)
    words = np.random.default_rng(1).dirichlet(np.ones(6), len(bumpy.vertices))
    bag = spatially_sensitive_bag(words, spectrum, 0.2)
    np.testing.assert_allclose(bag.sum(axis=1), bag_of_features(words, spectrum.mass), rtol=1e-6)


def test_pair_bag_at_late_times_forgets_the_places(bumpy: Mesh) -> None:
    spectrum = compute_spectrum(bumpy, 50)
    words = np.random.default_rng(2).dirichlet(np.ones(4), len(bumpy.vertices))
    plain = bag_of_features(words, spectrum.mass)
    late = spatially_sensitive_bag(words, spectrum, 1e3 / spectrum.eigenvalues[1])
    np.testing.assert_allclose(late, np.outer(plain, plain), rtol=1e-6)


def test_lists_are_arrays_and_lengths_must_fit(bumpy: Mesh) -> None:
    words = [[1.0, 0.0], [0.5, 0.5]]
    np.testing.assert_allclose(bag_of_features(words, [3.0, 1.0]), [0.875, 0.125])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="mass must have a row for each of 2 vertices, not 3"):
        bag_of_features(np.array(words), np.ones(3))
    spectrum = compute_spectrum(bumpy, 5)
    with pytest.raises(ValueError, match="words must have a row for each of 642 vertices, not 2"):
        spatially_sensitive_bag(np.array(words), spectrum, 1.0)
    with pytest.raises(ValueError, match="time must be a number ≥ 0, not -1"):
        spatially_sensitive_bag(np.ones((642, 2)), spectrum, -1.0)
