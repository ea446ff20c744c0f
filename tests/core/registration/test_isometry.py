# SPDX-License-Identifier: MIT
"""Functional maps between samples: poses are nearly isometric, other individuals are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.creatures import make_creature
from shapegoogle_core import Mesh, compute_spectrum
from shapegoogle_core.registration import SampleSettings, SurfaceSample, sample_surface
from shapegoogle_core.registration.isometry import functional_map, spectral_difference

Poses = tuple[SurfaceSample, SurfaceSample, SurfaceSample]


def sampled(mesh: Mesh) -> SurfaceSample:
    return sample_surface(mesh, compute_spectrum(mesh, k=40), SampleSettings(400, 160))


@pytest.fixture(scope="module")
def poses() -> Poses:
    """Two poses of a dog, and another dog."""
    creature = make_creature("dog", 900, vertex_count=1500)
    other = make_creature("dog", 901, vertex_count=1500)
    return sampled(creature.pose(1)), sampled(creature.pose(2)), sampled(other.pose(1))


def test_a_shape_is_isometric_to_itself(poses: Poses) -> None:
    found = functional_map(poses[0], poses[0])
    assert found.spectral_difference == 0
    assert found.orthogonality < 0.02
    assert found.commutativity < 0.02
    assert found.displacement < 0.02
    np.testing.assert_array_equal(found.counterparts, np.arange(160))


def test_signs_of_eigenfunctions_mean_nothing(poses: Poses) -> None:
    signs = np.where(np.random.default_rng(0).random(24) < 0.5, -1, 1)
    found = functional_map(poses[0], replace(poses[0], modes=poses[0].modes * signs.astype(np.float32)))
    np.testing.assert_array_equal(found.counterparts, np.arange(160))


def test_a_pose_is_nearer_to_an_isometry_than_another_individual(poses: Poses) -> None:
    pose, other = functional_map(poses[0], poses[1]), functional_map(poses[0], poses[2])
    assert pose.spectral_difference < 0.5 * other.spectral_difference
    assert pose.orthogonality < other.orthogonality
    assert pose.displacement > 0.02  # it has moved


def test_eigenvalues_are_compared_as_they_are_defined() -> None:
    def with_eigenvalues(*values: float) -> SurfaceSample:
        zeros = np.zeros((8, 3))
        looks, modes = np.zeros((8, 29), np.float32), np.zeros((8, len(values)), np.float32)
        return SurfaceSample(zeros, zeros, np.zeros(8), looks, np.array(values), modes, np.zeros(3), 1.0)

    first, second = with_eigenvalues(0, 2, 4, 9), with_eigenvalues(1, 2 * np.exp(1), 4)
    assert spectral_difference(first, second) == pytest.approx(np.sqrt(1 / 2))
    assert spectral_difference(first, with_eigenvalues()) == 0
    assert len(functional_map(first, with_eigenvalues(0, 0)).counterparts) == 8
