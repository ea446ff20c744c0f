# SPDX-License-Identifier: MIT
"""A whole small training on procedural shapes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
import pytest
import trimesh

from shapegoogle_core.errors import MeshError, ModelError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.model import ChannelSettings, ModelSettings, ShapeModel
from shapegoogle_core.model.training import TrainingShape, train_model
from shapegoogle_core.model.training.fitting import _agreements
from shapegoogle_core.preprocessing import PreprocessingSettings
from shapegoogle_core.registration import PreparedSample, SampleSettings, align, sample_surface
from shapegoogle_core.spectral import compute_spectrum
from tests.core.conftest import Shapes

A = TypeVar("A")
T = TypeVar("T")

SMALL = ModelSettings(
    name="small",
    channels=(ChannelSettings("log-hks", {"times": (0.002, 0.01, 0.05)}, words=8, bags=("area", "pairs")),),
    # Shapes of 162 vertices stay as small as they are.
    preprocessing=PreprocessingSettings(floor=150, budget=300, longest_edge=0.25),
    eigenpairs=40,
    projected=12,
    code_bits=16,
)


@pytest.fixture(scope="module")
def training_shapes(shapes: type[Shapes]) -> list[TrainingShape]:
    return [TrainingShape(f"bumpy-{seed}", (shapes.bumpy(2, seed),)) for seed in range(8)]


class Steps(dict[str, tuple[int, int]]):
    """Progress of a training: for each step the numbers of done and of all items."""

    def __call__(self, items: Iterable[T], description: str, total: int, /) -> Iterator[T]:
        self[description] = 0, total
        for done, item in enumerate(items, start=1):
            yield item
            self[description] = done, total


@pytest.fixture(scope="module")
def steps() -> Steps:
    """Progress of the training of `trained`."""
    return Steps()


@pytest.fixture(scope="module")
def trained(training_shapes: list[TrainingShape], steps: Steps) -> ShapeModel:
    return train_model(
        training_shapes,
        SMALL,
        versions=2,
        jobs=2,
        seed=3,
        trained_on="eight bumpy spheres",
        progress=steps,
    )


def test_training_finds_shapes_it_was_not_trained_on(trained: ShapeModel, shapes: type[Shapes]) -> None:
    model = trained
    assert model.trained_on == "eight bumpy spheres"
    unseen = [shapes.bumpy(2, seed) for seed in range(100, 106)]
    library = np.array([model.describe(mesh).bags for mesh in unseen])
    for index, mesh in enumerate(unseen):
        noise = np.random.default_rng(index).normal(scale=0.004, size=mesh.vertices.shape)
        query = model.describe(Mesh(mesh.vertices + noise, mesh.faces)).bags
        assert model.distances(query, library).argmin() == index


@pytest.mark.usefixtures("trained")
def test_every_long_step_shows_its_progress(steps: Steps) -> None:
    versions = 8 * 3
    assert steps == {
        "descriptors": (versions, versions),
        "vocabularies": (1, 1),
        "bags": (versions, versions),
    }


def test_each_pair_is_aligned_once(shapes: type[Shapes]) -> None:
    """However often it was chosen, and with the result that it has alone."""
    samples = []
    for seed in range(3):
        mesh = shapes.bumpy(3, seed)
        samples.append(sample_surface(mesh, compute_spectrum(mesh, 30), SampleSettings(200, 64)))
    first, second = np.array([0, 2, 0, 0, 0]), np.array([1, 1, 1, 2, 1])
    tasks: list[object] = []

    def run(function: Callable[[A], T], items: Sequence[A], /) -> Iterator[T]:
        tasks.extend(items)
        return map(function, items)

    steps = Steps()
    found = _agreements(samples, first, second, run, steps)
    assert len(tasks) == 2
    assert steps == {"alignments": (2, 2)}
    pairs = zip(first.tolist(), second.tolist(), strict=True)
    expected = [align(PreparedSample(samples[i]), PreparedSample(samples[j])).excess for i, j in pairs]
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_training_is_reproducible(trained: ShapeModel, training_shapes: list[TrainingShape]) -> None:
    """With and without processes."""
    again, other = (
        train_model(training_shapes, SMALL, versions=2, jobs=0, seed=seed, trained_on="eight bumpy spheres")
        for seed in (3, 4)
    )
    assert again.identifier == trained.identifier
    assert other.identifier != trained.identifier


def test_versions_that_cannot_be_made_are_left_out(training_shapes: list[TrainingShape]) -> None:
    """A shape of two faces: no sampling, no holes; the others still make a model."""
    flat = TrainingShape(
        "flat", (Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]),)
    )
    model = train_model([*training_shapes, flat], SMALL, versions=2, jobs=0)
    assert np.isfinite(model.projection).all()
    nothing = [TrainingShape(f"flat {n}", (Mesh(np.zeros((5, 3)), [[0, 1, 2]]),)) for n in range(8)]
    with pytest.raises(ModelError, match="none of the training shapes"):
        train_model(nothing, SMALL, versions=1, jobs=1)


@pytest.mark.parametrize("change", [{"metric": "l1"}, {"inverse_document_frequency": True}])
def test_training_with_the_papers_distances(shapes: type[Shapes], change: dict[str, Any]) -> None:
    # Distances of L1 tell smaller ones hardly apart.
    larger = [TrainingShape(f"bumpy-{seed}", (shapes.bumpy(3, seed),)) for seed in range(8)]
    finer = PreprocessingSettings(floor=500, budget=1000, longest_edge=0.1)
    settings = replace(SMALL, preprocessing=finer, eigenpairs=60, **change)
    model = train_model(larger, settings, versions=2, jobs=0)
    bags = np.array([model.describe(shape.meshes[0]).bags for shape in larger[:3]])
    distances = model.distances(bags[0], bags)
    assert distances[0] == pytest.approx(0, abs=1e-6)
    assert (distances[1:] > 0).all()
    if model.settings.inverse_document_frequency:  # it weighs every bag
        for weights in np.split(model.weights, np.cumsum(SMALL.channels[0].bag_sizes())[:-1]):
            assert (weights > 0).mean() > 0.9
            assert len(np.unique(weights)) > 1


def test_too_few_shapes(training_shapes: list[TrainingShape]) -> None:
    with pytest.raises(ModelError, match="at least 8 different usable shapes"):
        train_model(training_shapes[:7], SMALL)
    with pytest.raises(ModelError, match="not 1"):
        train_model([replace(shape, identity="one") for shape in training_shapes], SMALL)
    with pytest.raises(ValueError, match="at least one version"):
        train_model(training_shapes, SMALL, versions=0)


def test_shapes_may_be_meshes_of_other_libraries(bumpy: Mesh) -> None:
    pair = (bumpy.vertices, bumpy.faces)
    for meshes in (pair, [pair], (trimesh.Trimesh(*pair, process=False),), bumpy):
        (mesh,) = TrainingShape("bumpy", meshes).meshes
        np.testing.assert_array_equal(mesh.faces, bumpy.faces)
    with pytest.raises(MeshError, match="'x' is an object of the type int, not a mesh"):
        TrainingShape("x", [3])  # type: ignore[list-item]
    with pytest.raises(ValueError, match=r"shapes must be TrainingShape\(identity, meshes\), not Mesh"):
        train_model([bumpy] * 8, SMALL)  # type: ignore[list-item]
