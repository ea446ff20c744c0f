# SPDX-License-Identifier: MIT
"""Spatial support of many candidates at once: the definition, and what it finds."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from benchmarks.creatures import make_creature
from benchmarks.experiments.evidence_pairs import cut
from shapegoogle_core import Mesh, compute_spectrum
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration import (
    PreparedSample,
    SampleSettings,
    SurfaceSample,
    sample_surface,
    support,
    supports,
)
from shapegoogle_core.registration.prepared_sample import SHARED_SCALES

KINDS = ("dog", "bird", "horse", "human", "octopus")


def sampled(mesh: Mesh) -> SurfaceSample:
    scaled = Mesh(mesh.vertices / np.sqrt(mesh.area), mesh.faces)
    return sample_surface(scaled, compute_spectrum(scaled, 40), SampleSettings(300, 96))


@pytest.fixture(scope="module")
def meshes() -> list[Mesh]:
    return [make_creature(kind, 201, vertex_count=2000).rest for kind in KINDS]


@pytest.fixture(scope="module")
def samples(meshes: list[Mesh]) -> list[SurfaceSample]:
    return [sampled(mesh) for mesh in meshes]


def one_by_one(query: SurfaceSample, candidate: SurfaceSample, scale: float) -> float:
    """The definition, with loops."""
    count = support.KEYPOINTS
    descriptors = query.descriptors_at(scale)[:count]
    gaps = np.linalg.norm(descriptors[:, None].astype(float) - candidate.descriptors, axis=2)
    counterparts = gaps.argmin(axis=1)

    def pulled_apart(first: FloatArray, second: FloatArray, i: int, j: int) -> float:
        here = scale * np.linalg.norm(first[i] - first[j])
        return float(abs(here - np.linalg.norm(second[counterparts[i]] - second[counterparts[j]])))

    agree = np.zeros((count, count))
    for i, j in combinations(range(count), 2):
        near = all(
            pulled_apart(first, second, i, j) < support.TOLERANCE
            for first, second in ((query.points, candidate.points), (query.centers, candidate.centers))
        )
        agree[i, j] = agree[j, i] = near and counterparts[i] != counterparts[j]
    second_order = np.array(
        [[agree[i, j] * sum(agree[i] * agree[j]) for j in range(count)] for i in range(count)]
    )
    leader = second_order[second_order.sum(axis=1).argmax()]
    return float(np.sort(leader)[-support.SUPPORTERS :].mean() / count)


def test_support_is_that_of_the_definition(samples: list[SurfaceSample], meshes: list[Mesh]) -> None:
    query = sampled(cut(meshes[0], np.array([0.3, 1.0, 0.5]), 0.5))
    compared = np.ones((5, 5), bool)
    compared[1, 2] = compared[3, 0] = compared[4] = False
    found = supports(PreparedSample(query, SHARED_SCALES), samples, compared)
    assert (found[~compared] == 0).all()
    for row, column in ((0, 0), (0, 3), (1, 1), (2, 4), (3, 3)):
        expected = one_by_one(query, samples[row], SHARED_SCALES[column])
        # Distances are in single precision: a pair at the very tolerance may fall on either side.
        assert found[row, column] == pytest.approx(expected, abs=0.01)


def test_batch_size_does_not_matter(samples: list[SurfaceSample]) -> None:
    query = PreparedSample(samples[2], SHARED_SCALES)
    compared = np.random.default_rng(0).random((5, 5)) < 0.6
    together = supports(query, samples, compared)
    np.testing.assert_allclose(supports(query, samples, compared, batch_size=2), together, atol=1e-6)


def test_a_half_is_supported_by_its_whole_at_the_right_scale(
    samples: list[SurfaceSample], meshes: list[Mesh]
) -> None:
    for index, mesh in enumerate(meshes):
        half = PreparedSample(sampled(cut(mesh, np.array([0.3, 1.0, 0.5]), 0.5)), SHARED_SCALES)
        found = supports(half, samples, np.ones((5, 5), bool))
        row, column = np.unravel_index(found.argmax(), found.shape)
        assert row == index
        assert SHARED_SCALES[column] == 0.7  # √½


def test_nothing_to_compare_with(samples: list[SurfaceSample]) -> None:
    query = PreparedSample(samples[0], SHARED_SCALES)
    assert supports(query, [], np.ones((0, 5), bool)).shape == (0, 5)
    assert not supports(query, samples, np.zeros((5, 5), bool)).any()
