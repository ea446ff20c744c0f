# SPDX-License-Identifier: MIT
"""The learnt metric on made-up bags, and a whole small training on procedural shapes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from shapegoogle_core.errors import ModelError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.model import ChannelSettings, ModelSettings, row_distances
from shapegoogle_core.model.metric import calibrate, choose_pairs, learn_projection, rival_pairs
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.model.training import TrainingShape, train_model
from tests.core.conftest import Shapes


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


SMALL = ModelSettings(
    name="small",
    channels=(ChannelSettings("log-hks", {"times": (0.002, 0.01, 0.05)}, words=8, bags=("area", "pairs")),),
    projected=12,
    code_bits=16,
)


@pytest.fixture(scope="module")
def training_shapes(shapes: type[Shapes]) -> list[TrainingShape]:
    return [TrainingShape(f"bumpy-{seed}", (shapes.bumpy(3, seed),)) for seed in range(8)]


def test_training_finds_shapes_it_was_not_trained_on(
    training_shapes: list[TrainingShape], shapes: type[Shapes]
) -> None:
    model = train_model(training_shapes, SMALL, versions=4, jobs=2, trained_on="eight bumpy spheres")
    assert model.trained_on == "eight bumpy spheres"
    unseen = [shapes.bumpy(3, seed) for seed in range(100, 106)]
    library = np.array([model.describe(mesh).bags for mesh in unseen])
    for index, mesh in enumerate(unseen):
        noise = np.random.default_rng(index).normal(scale=0.004, size=mesh.vertices.shape)
        query = model.describe(Mesh(mesh.vertices + noise, mesh.faces)).bags
        assert model.distances(query, library).argmin() == index


def test_training_is_reproducible(training_shapes: list[TrainingShape]) -> None:
    first, second = (train_model(training_shapes, SMALL, versions=2, jobs=jobs, seed=3) for jobs in (1, 2))
    assert first.identifier == second.identifier
    other = train_model(training_shapes, SMALL, versions=2, seed=4)
    assert other.identifier != first.identifier


def test_idf_weighs_every_bag(training_shapes: list[TrainingShape]) -> None:
    model = train_model(training_shapes, replace(SMALL, inverse_document_frequency=True), versions=4)
    for weights in np.split(model.weights, np.cumsum(SMALL.channels[0].bag_sizes())[:-1]):
        assert (weights > 0).mean() > 0.9
        assert len(np.unique(weights)) > 1


def test_versions_that_cannot_be_made_are_left_out(training_shapes: list[TrainingShape]) -> None:
    """A shape of two faces: no sampling, no holes; the others still make a model."""
    flat = TrainingShape(
        "flat", (Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]),)
    )
    model = train_model([*training_shapes, flat], SMALL, versions=3)
    assert np.isfinite(model.projection).all()
    nothing = [TrainingShape(f"flat {n}", (Mesh(np.zeros((5, 3)), [[0, 1, 2]]),)) for n in range(8)]
    with pytest.raises(ModelError, match="none of the training shapes"):
        train_model(nothing, SMALL, versions=1)


@pytest.mark.parametrize("change", [{"metric": "l1"}, {"inverse_document_frequency": True}])
def test_training_with_the_papers_distances(
    training_shapes: list[TrainingShape], change: dict[str, Any]
) -> None:
    model = train_model(training_shapes, replace(SMALL, **change), versions=2)
    bags = np.array([model.describe(shape.meshes[0]).bags for shape in training_shapes[:3]])
    distances = model.distances(bags[0], bags)
    assert distances[0] == pytest.approx(0, abs=1e-6)
    assert (distances[1:] > 0).all()


def test_too_few_shapes(training_shapes: list[TrainingShape]) -> None:
    with pytest.raises(ModelError, match="at least 8 different usable shapes"):
        train_model(training_shapes[:7], SMALL)
    with pytest.raises(ModelError, match="not 1"):
        train_model([replace(shape, identity="one") for shape in training_shapes], SMALL)
    with pytest.raises(ValueError, match="at least one version"):
        train_model(training_shapes, SMALL, versions=0)
