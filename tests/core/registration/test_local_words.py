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
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.registration import (
    LocalSettings,
    LocalWords,
    SampleSettings,
    SurfaceSample,
    fit_local_words,
    sample_surface,
)
from shapegoogle_core.registration.prepared_sample import SHARED_SCALES

SETTINGS = LocalSettings(words=256)


def sampled(mesh: Mesh) -> SurfaceSample:
    scaled = Mesh(mesh.vertices / np.sqrt(mesh.area), mesh.faces)
    return sample_surface(scaled, compute_spectrum(scaled, 40), SampleSettings(300, 96))


@pytest.fixture(scope="module")
def creatures() -> list[Mesh]:
    return [make_creature(kind, 101, vertex_count=1200).rest for kind in CREATURE_KINDS[:16]]


@pytest.fixture(scope="module")
def samples(creatures: list[Mesh]) -> list[SurfaceSample]:
    return [sampled(mesh) for mesh in creatures]


@pytest.fixture(scope="module")
def local_words(samples: list[SurfaceSample]) -> LocalWords:
    return fit_local_words(samples, SETTINGS)


def scores(local_words: LocalWords, query: SurfaceSample, samples: list[SurfaceSample]) -> FloatBags:
    has = np.unpackbits([local_words.code(sample) for sample in samples], axis=1).astype(np.float32)
    return local_words.query_weights(query) @ has.T


def test_a_shape_has_all_its_own_words(local_words: LocalWords, samples: list[SurfaceSample]) -> None:
    for index, sample in enumerate(samples):
        weights = local_words.query_weights(sample)[0]
        found = scores(local_words, sample, samples)[0]
        assert found.argmax() == index
        assert found[index] == pytest.approx(weights.sum(), rel=1e-5)


def test_words_are_the_nearest_ones(local_words: LocalWords, samples: list[SurfaceSample]) -> None:
    """As by hand, at the query's own size."""
    gaps = samples[0].descriptors[:, None] - local_words.centers
    counts = np.bincount(np.linalg.norm(gaps, axis=2).argmin(axis=1), minlength=SETTINGS.words)
    np.testing.assert_array_equal(np.unpackbits(local_words.code(samples[0])), counts > 0)
    weights = local_words.query_weights(samples[0])
    assert weights.shape == (len(SHARED_SCALES), SETTINGS.words)
    np.testing.assert_allclose(weights[0], counts * local_words.weights, rtol=1e-6)


def test_a_part_has_words_of_its_whole(
    local_words: LocalWords, creatures: list[Mesh], samples: list[SurfaceSample]
) -> None:
    ranks = []
    for index in range(0, len(creatures), 2):
        part = sampled(transform(creatures[index], "partial", 4, seed=index))
        found = scores(local_words, part, samples)
        ranks.append((found > found[:, [index]]).sum(axis=1).min())
    assert np.median(ranks) <= 2  # of 16; half of them would be before it by chance


def test_weights_are_inverse_document_frequencies(
    local_words: LocalWords, samples: list[SurfaceSample]
) -> None:
    """Equation 17 by hand: a shape has the three nearest words of each of its keypoints."""
    shapes_with_word = np.zeros(SETTINGS.words)
    for sample in samples:
        gaps = np.linalg.norm(sample.descriptors[:, None] - local_words.centers, axis=2)
        shapes_with_word[np.unique(np.argsort(gaps, axis=1)[:, :3])] += 1
    expected = np.log(len(samples) / np.maximum(shapes_with_word, 1))
    np.testing.assert_allclose(local_words.weights, expected, rtol=1e-6)


def test_learning_is_repeatable(local_words: LocalWords, samples: list[SurfaceSample]) -> None:
    again = fit_local_words(samples, SETTINGS)
    for name in ("centers", "weights"):
        np.testing.assert_array_equal(getattr(again, name), getattr(local_words, name))


def test_too_few_keypoints(samples: list[SurfaceSample]) -> None:
    with pytest.raises(ModelError, match="2048 local words cannot be learnt from 96 keypoints"):
        fit_local_words(samples[:1], LocalSettings())


@pytest.mark.parametrize("words", [-8, 0, 100])
def test_bad_settings(words: int) -> None:
    with pytest.raises(ValueError, match="local words need"):
        LocalSettings(words)


@pytest.mark.parametrize("name", ["centers", "weights"])
def test_damaged_words(local_words: LocalWords, name: str) -> None:
    damaged = getattr(local_words, name).copy()
    damaged.flat[0] = np.nan
    with pytest.raises(ModelError, match=f"damaged: {name}"):
        replace(local_words, **{name: damaged})
