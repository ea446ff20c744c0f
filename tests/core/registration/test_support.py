# SPDX-License-Identifier: MIT
"""Support: how many correspondences agree with each other, for many candidates at once."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from benchmarks.creatures import make_creature
from benchmarks.experiments.evidence_pairs import cut
from shapegoogle_core import Mesh, compute_spectrum
from shapegoogle_core.registration import (
    PreparedSample,
    SampleSettings,
    SurfaceSample,
    sample_surface,
    screening,
    supports,
)
from shapegoogle_core.registration.alignment import SHARED_SCALES

KINDS = ("dog", "bird", "horse", "human", "octopus")


def sampled(mesh: Mesh) -> SurfaceSample:
    scaled = Mesh(mesh.vertices / np.sqrt(mesh.area), mesh.faces)
    return sample_surface(scaled, compute_spectrum(scaled, 40), SampleSettings(300, 96))


@pytest.fixture(scope="module")
def meshes() -> list[Mesh]:
    return [make_creature(kind, 201, vertex_count=2000).rest for kind in KINDS]


@pytest.fixture(scope="module")
def samples(meshes) -> list[SurfaceSample]:
    return [sampled(mesh) for mesh in meshes]


def one_by_one(query: SurfaceSample, candidate: SurfaceSample, scale: float) -> float:
    """The definition, with loops."""
    count = screening._KEYPOINTS
    looks = query.descriptors_at(scale)[:count]
    gaps = np.linalg.norm(looks[:, None].astype(float) - candidate.descriptors, axis=2)
    there = gaps.argmin(axis=1)

    def pulled_apart(first: np.ndarray, second: np.ndarray, i: int, j: int) -> float:
        here = scale * np.linalg.norm(first[i] - first[j])
        return abs(here - np.linalg.norm(second[there[i]] - second[there[j]]))

    agree = np.zeros((count, count))
    for i, j in combinations(range(count), 2):
        near = all(
            pulled_apart(first, second, i, j) < screening._AGREEMENT
            for first, second in ((query.points, candidate.points), (query.centers, candidate.centers))
        )
        agree[i, j] = agree[j, i] = near and there[i] != there[j]
    second_order = np.array(
        [[agree[i, j] * sum(agree[i] * agree[j]) for j in range(count)] for i in range(count)]
    )
    leader = second_order[second_order.sum(axis=1).argmax()]
    return float(np.sort(leader)[-screening._SUPPORTERS :].mean() / count)


def test_it_is_what_its_definition_says(samples, meshes):
    query = sampled(cut(meshes[0], np.array([0.3, 1.0, 0.5]), 0.5))
    asked = np.ones((5, 5), bool)
    asked[1, 2] = asked[3, 0] = asked[4] = False
    found = supports(PreparedSample(query, SHARED_SCALES), samples, asked)
    assert (found[~asked] == 0).all()
    for row, column in ((0, 0), (0, 3), (1, 1), (2, 4), (3, 3)):
        expected = one_by_one(query, samples[row], SHARED_SCALES[column])
        # Distances are in single precision: a pair at the very tolerance may fall on either side.
        assert found[row, column] == pytest.approx(expected, abs=0.01)


def test_how_many_are_compared_at_once_does_not_matter(samples, monkeypatch):
    query = PreparedSample(samples[2], SHARED_SCALES)
    asked = np.random.default_rng(0).random((5, 5)) < 0.6
    together = supports(query, samples, asked)
    monkeypatch.setattr(screening, "_AT_ONCE", 2)
    np.testing.assert_allclose(supports(query, samples, asked), together, atol=1e-6)


def test_a_half_is_supported_by_its_whole_at_the_right_scale(samples, meshes):
    for index, mesh in enumerate(meshes):
        half = PreparedSample(sampled(cut(mesh, np.array([0.3, 1.0, 0.5]), 0.5)), SHARED_SCALES)
        found = supports(half, samples, np.ones((5, 5), bool))
        row, column = np.unravel_index(found.argmax(), found.shape)
        assert row == index
        assert SHARED_SCALES[column] == 0.7  # √½


def test_nothing_to_compare_with(samples):
    query = PreparedSample(samples[0], SHARED_SCALES)
    assert supports(query, [], np.ones((0, 5), bool)).shape == (0, 5)
    assert not supports(query, samples, np.zeros((5, 5), bool)).any()
