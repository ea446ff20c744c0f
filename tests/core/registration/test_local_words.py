# SPDX-License-Identifier: MIT
"""The index of parts: what is cut off a shape leaves most of its local words as they were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.creatures import CREATURE_KINDS, make_creature
from shapegoogle_core import Mesh, compute_spectrum
from shapegoogle_core.errors import ModelError
from shapegoogle_core.model.augmentation import transform
from shapegoogle_core.registration import (
    LocalSettings,
    LocalWords,
    SampleSettings,
    SurfaceSample,
    fit_local_words,
    sample_surface,
)
from shapegoogle_core.registration.prepared_sample import SHARED_SCALES

SETTINGS = LocalSettings(words=256, bits=128)


def sampled(mesh: Mesh) -> SurfaceSample:
    scaled = Mesh(mesh.vertices / np.sqrt(mesh.area), mesh.faces)
    return sample_surface(scaled, compute_spectrum(scaled, 40), SampleSettings(300, 96))


@pytest.fixture(scope="module")
def creatures() -> list[Mesh]:
    return [make_creature(kind, 101, vertex_count=1200).rest for kind in CREATURE_KINDS[:16]]


@pytest.fixture(scope="module")
def samples(creatures) -> list[SurfaceSample]:
    return [sampled(mesh) for mesh in creatures]


@pytest.fixture(scope="module")
def local_words(samples) -> LocalWords:
    return fit_local_words(samples, SETTINGS)


def scores(local_words: LocalWords, query: SurfaceSample, samples: list[SurfaceSample]) -> np.ndarray:
    has = np.unpackbits([local_words.code(sample) for sample in samples], axis=1).astype(np.float32)
    return local_words.query_weights(query) @ has.T


def test_a_shape_has_all_its_own_words(local_words, samples):
    for index, sample in enumerate(samples):
        weights = local_words.query_weights(sample)[0]
        found = scores(local_words, sample, samples)[0]
        assert found.argmax() == index
        assert found[index] == pytest.approx(weights.sum(), rel=1e-5)


def test_words_are_the_nearest_ones(local_words, samples):
    """As by hand, at the query's own size."""
    gaps = samples[0].descriptors[:, None] - local_words.centers
    counts = np.bincount(np.linalg.norm(gaps, axis=2).argmin(axis=1), minlength=SETTINGS.words)
    np.testing.assert_array_equal(np.unpackbits(local_words.code(samples[0])), counts > 0)
    weights = local_words.query_weights(samples[0])
    assert weights.shape == (len(SHARED_SCALES), SETTINGS.words)
    np.testing.assert_allclose(weights[0], counts * local_words.weights, rtol=1e-6)


def test_a_part_has_words_of_its_whole(local_words, creatures, samples):
    ranks = []
    for index in range(0, len(creatures), 2):
        part = sampled(transform(creatures[index], "partial", 4, seed=index))
        found = scores(local_words, part, samples)
        ranks.append((found > found[:, [index]]).sum(axis=1).min())
    assert np.median(ranks) <= 2  # of 16; half of them would be before it by chance


def test_a_bag_counts_the_nearest_words(local_words):
    """As by hand: the square roots of counts, weighted and of unit length."""
    descriptors = np.random.default_rng(0).normal(local_words.centers.mean(axis=0), 1, (5, 29))
    counts = np.zeros(SETTINGS.words)
    for descriptor in descriptors:
        counts[np.argsort(np.linalg.norm(local_words.centers - descriptor, axis=1))[:3]] += 1
    expected = np.sqrt(counts) * local_words.weights
    expected /= np.linalg.norm(expected)
    np.testing.assert_allclose(local_words.bag(descriptors.astype(np.float32)), expected, atol=1e-6)


def test_learning_is_repeatable(local_words, samples):
    again = fit_local_words(samples, SETTINGS)
    for name in ("centers", "weights", "mean", "directions"):
        np.testing.assert_array_equal(getattr(again, name), getattr(local_words, name))


def test_too_few_keypoints(samples):
    with pytest.raises(ModelError, match="2048 local words cannot be learnt from 96 keypoints"):
        fit_local_words(samples[:1], LocalSettings())


@pytest.mark.parametrize("values", [{"words": 0}, {"words": 100}, {"bits": 0}, {"bits": 12}])
def test_bad_settings(values):
    with pytest.raises(ValueError, match="local words need"):
        LocalSettings(**values)


@pytest.mark.parametrize("name", ["centers", "weights", "mean"])
def test_damaged_words(local_words, name):
    damaged = getattr(local_words, name).copy()
    damaged.flat[0] = np.nan
    with pytest.raises(ModelError, match=f"damaged: {name}"):
        replace(local_words, **{name: damaged})
