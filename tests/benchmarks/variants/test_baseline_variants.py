# SPDX-License-Identifier: MIT
"""Baselines as rows of the benchmark."""

from __future__ import annotations

import numpy as np

from benchmarks.protocol.collection import Collection
from benchmarks.protocol.workshop import Workshop
from benchmarks.variants.bag_variants import Preparation
from benchmarks.variants.baseline_variants import mesh_groups, spectrum_groups
from benchmarks.variants.baselines import (
    d2_distribution,
    diffusion_distances,
    gps_distances,
    shape_dna,
    surface_moments,
)
from shapegoogle_core.model import PRESETS
from shapegoogle_core.spectral import compute_spectrum
from tests.benchmarks.conftest import relevant_columns


def test_shape_dna_is_compared_by_the_euclidean_distance(workshop: Workshop, collection: Collection) -> None:
    group = spectrum_groups(Preparation("paper", PRESETS["paper"]), seed=0)[0]
    (entry,) = group.match(workshop, collection.queries[:2], collection.database)
    first, second = (
        shape_dna(compute_spectrum(shape.mesh(), 200, "cotangent"))
        for shape in (collection.queries[1], collection.database[3])
    )
    np.testing.assert_allclose(entry.distances[1, 3], np.linalg.norm(first - second), rtol=1e-4)
    assert entry.bytes_per_shape == 4 * 49


def test_distances_and_moments_are_compared_by_l1(workshop: Workshop, collection: Collection) -> None:
    groups = [*spectrum_groups(Preparation("paper", PRESETS["paper"]), seed=3)[1:], mesh_groups(3)[1]]
    names = ["diffusion distances", "GPS distances", "moments"]
    assert [group.variants[0].name for group in groups] == names
    shapes = (collection.queries[1], collection.database[3])
    spectra = [compute_spectrum(shape.mesh(), 200, "cotangent") for shape in shapes]
    expected = [
        [diffusion_distances(spectrum, seed=3) for spectrum in spectra],
        [gps_distances(spectrum, seed=3) for spectrum in spectra],
        [surface_moments(shape.mesh()) for shape in shapes],
    ]
    for group, (first, second) in zip(groups, expected, strict=True):
        (entry,) = group.match(workshop, collection.queries[:2], collection.database)
        np.testing.assert_allclose(entry.distances[1, 3], np.abs(first - second).sum(), rtol=0.02)
        assert 0 < entry.describe_seconds < 10


def test_d2_is_compared_by_l1(workshop: Workshop, collection: Collection) -> None:
    (entry,) = mesh_groups(5)[0].match(workshop, collection.queries[:1], collection.database)
    first, second = (
        d2_distribution(shape.mesh(), seed=5) for shape in (collection.queries[0], collection.database[3])
    )
    np.testing.assert_allclose(entry.distances[0, 3], np.abs(first - second).sum(), rtol=1e-4)
    assert entry.distances[0].argmin() == relevant_columns(collection)[0]
