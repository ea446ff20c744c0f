# SPDX-License-Identifier: MIT
"""Baselines as rows of the benchmark."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.evaluation.bag_variants import Preparation
from shapegoogle_core.evaluation.baseline_variants import d2_group, shape_dna_group
from shapegoogle_core.evaluation.baselines import d2_distribution, shape_dna
from shapegoogle_core.settings import PRESETS
from shapegoogle_core.spectrum import compute_spectrum


def test_shape_dna_is_compared_by_the_euclidean_distance(workshop, collection) -> None:
    group = shape_dna_group(Preparation("paper", PRESETS["paper"]))
    (entry,) = group.match(workshop, collection.queries[:2], collection.database)
    first, second = (
        shape_dna(compute_spectrum(shape.mesh(), 200, "cotangent"))
        for shape in (collection.queries[1], collection.database[3])
    )
    np.testing.assert_allclose(entry.distances[1, 3], np.linalg.norm(first - second), rtol=1e-4)
    assert entry.bytes_per_shape == 4 * 49


def test_d2_is_compared_by_l1(workshop, collection) -> None:
    (entry,) = d2_group(5).match(workshop, collection.queries[:1], collection.database)
    first, second = (
        d2_distribution(shape.mesh(), seed=5) for shape in (collection.queries[0], collection.database[3])
    )
    np.testing.assert_allclose(entry.distances[0, 3], np.abs(first - second).sum(), rtol=1e-4)
    assert entry.distances[0].argmin() == collection.relevant_columns[0]
