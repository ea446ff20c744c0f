# SPDX-License-Identifier: MIT
"""Samples of a surface: evenly spread, described in a way that motions do not change, stored in few bytes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from shapegoogle_core import Mesh, compute_spectrum
from shapegoogle_core.descriptors import spin_images
from shapegoogle_core.model.shape_bags import FloatBags
from shapegoogle_core.registration import SampleSettings, SurfaceSample, sample_surface
from shapegoogle_core.registration.sample import farthest_points
from tests.core.conftest import Shapes


@pytest.fixture(scope="module")
def sample(shapes: type[Shapes]) -> SurfaceSample:
    mesh = shapes.bumpy(3)
    return sample_surface(mesh, compute_spectrum(mesh, k=40), SampleSettings(200, 64))


def test_a_sphere_is_sampled_at_its_radius(shapes: type[Shapes]) -> None:
    mesh = shapes.sphere(4)
    sample = sample_surface(mesh, compute_spectrum(mesh, k=30), SampleSettings(300, 50))
    radius = 1 / np.sqrt(4 * np.pi)  # of unit area
    np.testing.assert_allclose(np.linalg.norm(sample.points, axis=1), radius, rtol=0.05)
    outward = sample.points / np.linalg.norm(sample.points, axis=1, keepdims=True)
    assert np.median(np.abs((outward * sample.normals).sum(axis=1))) > 0.995
    # All balls are the sphere itself.
    np.testing.assert_allclose(np.abs(sample.radii), radius, rtol=0.15)
    np.testing.assert_allclose(sample.centers, 0, atol=0.05)
    # Evenly: no two closer than half of what a hexagonal pattern of so many points has.
    distances = np.linalg.norm(sample.points[:, None] - sample.points[None], axis=2)
    np.fill_diagonal(distances, np.inf)
    assert distances.min() > 0.5 * np.sqrt(2 / (np.sqrt(3) * 300))


def test_samples_forget_place_and_size(shapes: type[Shapes], sample: SurfaceSample) -> None:
    mesh = shapes.bumpy(3)
    turn = Rotation.from_euler("xyz", [0.4, -1.1, 2.0]).as_matrix()
    moved = Mesh(7 * mesh.vertices @ turn.T + [10, -3, 5], mesh.faces)
    other = sample_surface(moved, compute_spectrum(moved, k=40), SampleSettings(200, 64))
    np.testing.assert_allclose(other.points, sample.points @ turn.T, atol=1e-6)
    np.testing.assert_allclose(other.descriptors, sample.descriptors, atol=0.1)
    np.testing.assert_allclose(other.eigenvalues, sample.eigenvalues, rtol=1e-6)
    # Both know where they were.
    there = other.center + other.unit * other.points
    back = (there - [10, -3, 5]) @ turn / 7
    np.testing.assert_allclose(back, sample.center + sample.unit * sample.points, atol=1e-5)


def test_bytes_and_back(sample: SurfaceSample) -> None:
    content = sample.to_bytes()
    assert len(content) == 44 + 10 * 200 + sample.descriptors.size + sample.modes.size + 4 * 24
    back = SurfaceSample.from_bytes(content)
    np.testing.assert_allclose(back.points, sample.points, atol=2e-4)
    np.testing.assert_allclose(back.normals, sample.normals, atol=5e-3)
    np.testing.assert_allclose(back.radii, sample.radii, atol=2e-3)
    np.testing.assert_allclose(back.centers, sample.centers, atol=6e-3)
    np.testing.assert_allclose(back.descriptors, sample.descriptors, atol=0.05)
    np.testing.assert_allclose(back.modes, sample.modes, atol=0.04)
    np.testing.assert_allclose(back.eigenvalues, sample.eigenvalues, rtol=1e-6)
    np.testing.assert_array_equal(back.center, sample.center)
    assert back.unit == sample.unit
    assert back.to_bytes() == content


def test_descriptors_at_another_scale_are_those_of_a_larger_surface(shapes: type[Shapes]) -> None:
    """A part of a surface and the whole: told how much larger the whole is, the part looks more like it."""
    whole = shapes.bumpy(4, seed=3)
    whole = Mesh(whole.vertices * [1.0, 1.0, 3.0], whole.faces)
    part = Mesh(whole.vertices, whole.faces[whole.vertices[whole.faces].mean(axis=1)[:, 2] < 0.8])
    used, corners = np.unique(part.faces, return_inverse=True)
    part = Mesh(part.vertices[used], corners.reshape(-1, 3))
    settings = SampleSettings(600, 300)
    first, second = (sample_surface(mesh, compute_spectrum(mesh, k=80), settings) for mesh in (part, whole))
    scale = np.sqrt(part.area / whole.area)
    assert 0.6 < scale < 0.9
    np.testing.assert_allclose(first.descriptors_at(1 + 1e-9), first.descriptors, atol=1e-3)
    assert len(first.descriptors_at(scale, 10)) == 10
    middle = first.points[:300, 2] < np.quantile(first.points[:, 2], 0.4)

    def unlikeness(descriptors: FloatBags) -> float:
        gaps = np.linalg.norm(descriptors[middle, None] - second.descriptors[None], axis=2)
        return float(np.median(gaps.min(axis=1)))

    assert unlikeness(first.descriptors_at(scale, 300)) < 0.85 * unlikeness(first.descriptors)


@pytest.mark.parametrize("damage", [b"", b"abc", bytes(10), b"\x01\x00\x01\x00\x01\x00\x00\x00\x80\x3f"])
def test_damaged_bytes_are_refused(damage: bytes, sample: SurfaceSample) -> None:
    with pytest.raises(ValueError, match="surface sample"):
        SurfaceSample.from_bytes(damage)
    with pytest.raises(ValueError, match="surface sample"):
        SurfaceSample.from_bytes(sample.to_bytes()[:-1])


@pytest.mark.parametrize(("points", "keypoints"), [(100, 7), (50, 51), (70_000, 100)])
def test_settings_out_of_range(points: int, keypoints: int) -> None:
    with pytest.raises(ValueError, match="keypoints"):
        SampleSettings(points, keypoints)


def test_farthest_points_are_those_of_the_definition() -> None:
    points = np.random.default_rng(0).standard_normal((60, 3))
    chosen = farthest_points(points, 20)
    assert chosen[0] == np.linalg.norm(points, axis=1).argmax()
    for count in range(1, 20):
        gaps = np.linalg.norm(points[:, None] - points[None, chosen[:count]], axis=2).min(axis=1)
        assert gaps[chosen[count]] == pytest.approx(gaps.max(), rel=1e-5)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_spin_images_count_as_the_definition_says(seed: int) -> None:
    random = np.random.default_rng(seed)
    points, cloud = random.standard_normal((4, 3)), random.standard_normal((200, 3))
    normals, weights = random.standard_normal((4, 3)), random.uniform(0, 1, 200)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    images = spin_images(points, normals, cloud, weights, 1.5, (5, 3)).reshape(4, 5, 3)
    for point, normal, image in zip(points, normals, images, strict=True):
        height = np.abs((cloud - point) @ normal)
        across = np.linalg.norm(np.cross(cloud - point, normal), axis=1)
        expected, _, _ = np.histogram2d(across, height, (5, 3), ((0, 1.5), (0, 1.5)), weights=weights)
        np.testing.assert_allclose(image, expected)


def test_parts_far_apart_are_stored_as_well(shapes: type[Shapes]) -> None:
    sphere, box = shapes.sphere(3), shapes.sphere(2)
    far = Mesh(
        np.concatenate([sphere.vertices, box.vertices + np.array([400, 0, 0])]),
        np.concatenate([sphere.faces, box.faces + len(sphere.vertices)]),
    )
    sample = sample_surface(far, compute_spectrum(far, k=20), SampleSettings(200, 64))
    back = SurfaceSample.from_bytes(sample.to_bytes())
    np.testing.assert_allclose(back.points, sample.points, atol=np.abs(sample.points).max() / 60_000)
