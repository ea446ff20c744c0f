# SPDX-License-Identifier: MIT
"""Aligning surfaces: the motion that was made is found again, also with a part missing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from threadpoolctl import threadpool_limits

from shapegoogle_core import Mesh, compute_spectrum
from shapegoogle_core.model.augmentation import transform
from shapegoogle_core.preprocessing import PreprocessingSettings, preprocess
from shapegoogle_core.registration import PreparedSample, SampleSettings, SurfaceSample, align, sample_surface
from tests.core.conftest import Shapes


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """On matrices of this size more threads of BLAS only get in each other's way."""
    with threadpool_limits(1, user_api="blas"):
        yield


def sampled(mesh: Mesh) -> PreparedSample:
    mesh = preprocess(mesh, PreprocessingSettings(budget=2000))
    return PreparedSample(sample_surface(mesh, compute_spectrum(mesh, k=60), SampleSettings(400, 128)))


@pytest.fixture(scope="module")
def bumpy(shapes: type[Shapes]) -> Mesh:
    mesh = shapes.bumpy(4, seed=3)
    return Mesh(mesh.vertices * [1.0, 1.3, 2.0], mesh.faces)


def test_a_moved_surface_is_laid_back(bumpy: Mesh) -> None:
    turn = Rotation.from_euler("xyz", [0.5, 1.2, -2.0]).as_matrix()
    moved = Mesh(3 * bumpy.vertices @ turn.T + 4, bumpy.faces)
    alignment = align(sampled(moved), sampled(bumpy))
    np.testing.assert_allclose(alignment.frame.rotation, turn.T, atol=0.08)
    assert alignment.frame.scale == pytest.approx(1, abs=0.02)
    assert alignment.agreement > 0.9
    assert alignment.excess == pytest.approx((alignment.agreement - 0.25) ** 2)


@pytest.mark.parametrize("kind", ["partial", "noise", "holes", "topology", "sampling"])
def test_a_damaged_surface_still_fits(bumpy: Mesh, kind: str) -> None:
    damaged = transform(bumpy, kind, 2, seed=1)
    turn = Rotation.from_euler("zyx", [1.0, 0.3, -0.7]).as_matrix()
    alignment = align(sampled(Mesh(damaged.vertices @ turn.T, damaged.faces)), sampled(bumpy))
    np.testing.assert_allclose(alignment.frame.rotation, turn.T, atol=0.1)
    assert alignment.agreement > 0.6


def test_a_part_lies_on_its_whole_and_not_the_reverse(bumpy: Mesh) -> None:
    keep = bumpy.vertices[bumpy.faces].mean(axis=1)[:, 2] < 0.7
    part = Mesh(bumpy.vertices, bumpy.faces[keep])
    used, corners = np.unique(part.faces, return_inverse=True)
    part = Mesh(part.vertices[used], corners.reshape(-1, 3))
    share = part.area / bumpy.area
    assert 0.6 < share < 0.85
    alignment = align(sampled(part), sampled(bumpy))
    assert alignment.frame.scale == pytest.approx(np.sqrt(share), abs=0.02)
    assert alignment.query_covered[1] > 0.8
    assert alignment.candidate_covered[1] == pytest.approx(share * alignment.query_covered[1], abs=0.12)


def test_a_swollen_limb_keeps_its_axis(shapes: type[Shapes]) -> None:
    """A rod, one half blown up: its surface leaves the other one's, its axis does not."""
    rod = shapes.sphere(4)
    along = rod.vertices[:, 2:]
    thin = Mesh(rod.vertices * [1, 1, 6] * [0.5, 0.5, 1], rod.faces)
    thick = Mesh(thin.vertices * np.where([True, True, False], 1 + np.clip(along, 0, 1), 1), rod.faces)
    alignment = align(sampled(thick), sampled(thin))
    assert alignment.query_axis_covered.mean() > alignment.query_covered.mean() + 0.1


def test_other_surfaces_agree_less(bumpy: Mesh, shapes: type[Shapes]) -> None:
    others = [sampled(shapes.bumpy(4, seed=seed)) for seed in range(20, 24)]
    itself = align(sampled(transform(bumpy, "noise", 3, seed=0)), sampled(bumpy)).agreement
    assert max(align(sampled(bumpy), other).agreement for other in others) < 0.8 * itself


def test_a_handful_of_points_in_one_place() -> None:
    """Nothing to lay over: no agreement, and no error."""
    normals, zeros = np.tile([0.0, 0, 1], (8, 1)), np.zeros((8, 3))
    looks, modes = np.zeros((8, 29), np.float32), np.zeros((8, 0), np.float32)
    nothing = SurfaceSample(zeros, normals, np.zeros(8), looks, np.zeros(0), modes, np.zeros(3), 1.0)
    alignment = align(PreparedSample(nothing), PreparedSample(nothing))
    assert 0 <= alignment.agreement <= 1
    assert 0 <= alignment.excess <= 0.75**2


@pytest.mark.parametrize("points", [8, 100, 240])
def test_samples_of_any_size_can_be_aligned(bumpy: Mesh, points: int) -> None:
    sample = sample_surface(bumpy, compute_spectrum(bumpy, k=30), SampleSettings(points, 8))
    alignment = align(PreparedSample(sample), PreparedSample(sample))
    assert 0 <= alignment.agreement <= 1
