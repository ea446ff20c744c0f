# SPDX-License-Identifier: MIT
"""The learnt metric and its calibration, on made-up bags."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import row_distances
from shapegoogle_core.model.metric import calibrate, choose_pairs, learn_projection, rival_pairs
from shapegoogle_core.model.shape_bags import FloatBags


def versions_of_shapes(
    seed: int = 0, shapes: int = 60, versions: int = 8, size: int = 30
) -> tuple[FloatBags, NDArray[np.int64]]:
    """Bags that differ between shapes everywhere, and between versions mostly along a third of the axes."""
    random = np.random.default_rng(seed)
    mixing, _ = np.linalg.qr(np.random.default_rng(99).standard_normal((size, size)))
    centers = random.standard_normal((shapes, 1, size))
    spread = np.where(np.arange(size) < size // 3, 4.0, 0.3)
    bags = (centers + spread * random.standard_normal((shapes, versions, size))) @ mixing
    return bags.reshape(-1, size).astype(np.float32), np.repeat(np.arange(shapes), versions)


def first_share(vectors: FloatArray | FloatBags, labels: NDArray[np.int64]) -> float:
    """Share of versions whose nearest other version is of the same shape."""
    unit = (vectors / np.linalg.norm(vectors, axis=1, keepdims=True)).astype(np.float32)
    distances = np.array([row_distances("cosine", row[None], unit) for row in unit])
    np.fill_diagonal(distances, np.inf)
    return float((labels[distances.argmin(axis=1)] == labels).mean())


def test_projection_learns_what_transformations_change() -> None:
    bags, labels = versions_of_shapes()
    mean, projection = learn_projection(bags, labels, dimensions=30, shrinkage=0.05)
    bags, labels = versions_of_shapes(seed=1)  # other shapes, the same transformations
    plain = first_share(bags - mean, labels)
    learnt = first_share((bags - mean) @ projection, labels)
    assert plain < 0.6
    assert learnt > 0.95


def test_full_shrinkage_is_principal_components() -> None:
    bags, labels = versions_of_shapes()
    mean, projection = learn_projection(bags, labels, dimensions=30, shrinkage=1.0)
    projected = (bags - mean) @ projection
    original = np.linalg.norm(bags[:50, None] - bags[None, :50], axis=2)
    np.testing.assert_allclose(
        np.linalg.norm(projected[:50, None] - projected[None, :50], axis=2), original, rtol=1e-3, atol=1e-3
    )


@pytest.mark.parametrize("count", [20, 480])
def test_fewer_bags_than_entries(count: int) -> None:
    """Both sides of the Gram matrix lead to the same distances."""
    bags, labels = versions_of_shapes(size=60)
    _, projection = learn_projection(bags[:count], labels[:count], dimensions=100, shrinkage=0.5)
    assert projection.shape[0] == 60
    assert projection.shape[1] <= min(count - 1, 60)
    assert np.isfinite(projection).all()


def test_pairs_are_labelled_right() -> None:
    labels = np.repeat(np.arange(5), [1, 2, 3, 4, 5])
    first, second, similar = choose_pairs(labels, np.random.default_rng(0), count=100)
    np.testing.assert_array_equal(labels[first] == labels[second], similar)
    assert (first != second).all()
    assert similar.sum() == 100


def test_rivals_are_the_nearest_of_many() -> None:
    bags, labels = versions_of_shapes()
    first, second, similar = rival_pairs("l1", bags, labels, np.random.default_rng(0), count=300)
    np.testing.assert_array_equal(labels[first] == labels[second], similar)
    assert similar.sum() == (~similar).sum() == 300
    distances = row_distances("l1", bags[first], bags[second])
    first, second, same = choose_pairs(labels, np.random.default_rng(0), count=300)
    any_other = row_distances("l1", bags[first], bags[second])[~same]
    assert np.median(distances[~similar]) < np.quantile(any_other, 0.1)


def test_calibration_recovers_the_probability() -> None:
    random = np.random.default_rng(0)
    distances = random.uniform(0.01, 1.0, 20_000)
    similar = random.uniform(size=20_000) < 1 / (1 + (distances / 0.3) ** 4)
    # Logistic regression gives both kinds the same weight; put the prior back before comparing.
    found = calibrate(distances, similar)
    prior = similar.mean() / (1 - similar.mean())
    assert found.slope == pytest.approx(4, rel=0.1)
    assert found.half == pytest.approx(0.3 * prior ** (-1 / 4), rel=0.05)
    assert found.gain == 0


def test_calibration_recovers_what_an_agreement_says() -> None:
    random = np.random.default_rng(0)
    distances, agreements = random.uniform(0.01, 1.0, 20_000), random.uniform(0, 0.8, 20_000)
    verified = distances * np.exp(-2 * agreements)
    similar = random.uniform(size=20_000) < 1 / (1 + (verified / 0.3) ** 4)
    found = calibrate(distances, similar, agreements)
    assert found.slope == pytest.approx(4, rel=0.1)
    assert found.gain == pytest.approx(2, rel=0.1)


def test_calibration_refuses_what_cannot_be_told_apart() -> None:
    distances = np.random.default_rng(0).uniform(0.1, 1.0, 1000)
    with pytest.raises(ModelError, match="more varied"):
        calibrate(distances, distances > 0.5)


def test_agreements_that_tell_all_pairs_apart() -> None:
    """As those of few shapes may: then distances are calibrated on their own."""
    random = np.random.default_rng(4)
    similar = np.arange(400) < 200
    distances = np.exp(random.normal(np.where(similar, -1.0, 0.0), 0.8))
    # Among surfaces that agree less, those of one shape are farther apart.
    agreements = np.where(similar, 0.3, 0.0) + 0.05 * np.log(distances)
    found = calibrate(distances, similar, agreements)
    assert found.slope > 0
    assert found.gain >= 0
    assert np.isfinite([found.half, found.slope, found.gain]).all()
