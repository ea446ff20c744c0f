# SPDX-License-Identifier: MIT
"""Fitting points to a surface: known motions come back to rounding errors."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapegoogle_core import Mesh, compute_spectrum
from shapegoogle_core.registration import SampleSettings, SurfaceSample, sample_surface
from shapegoogle_core.registration.fit.surface_fit import (
    Surface,
    best_frame,
    fit_surface,
    frame_between,
    measured,
    mirrored,
)
from shapegoogle_core.registration.frames import Frame
from tests.core.conftest import Shapes


def sampled(mesh: Mesh, points: int = 200) -> SurfaceSample:
    return sample_surface(mesh, compute_spectrum(mesh, k=30), SampleSettings(points, 64))


@pytest.fixture(scope="module")
def bumpy(shapes: type[Shapes]) -> Mesh:
    mesh = shapes.bumpy(4, seed=3)
    return Mesh(5 * mesh.vertices * [1.0, 1.3, 2.0] + [10, 0, -3], mesh.faces)


@pytest.fixture(scope="module")
def sample(bumpy: Mesh) -> SurfaceSample:
    return sampled(bumpy)


def test_nearest_points_are_the_nearest_of_all_faces(bumpy: Mesh, sample: SurfaceSample) -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (40, 3))
    nearest, normals = Surface(bumpy, sample).nearest(points)
    triangles = ((bumpy.vertices - sample.center) / sample.unit)[bumpy.faces]
    # Dense points on all faces cannot be nearer, and one of them is nearly as near.
    random = np.random.default_rng(1).dirichlet(np.ones(3), size=60)
    dense = np.einsum("bk,fkd->bfd", random, triangles).reshape(-1, 3)
    best = np.linalg.norm(points[:, None] - dense[None], axis=2).min(axis=1)
    found = np.linalg.norm(points - nearest, axis=1)
    assert (found <= best + 1e-12).all()
    np.testing.assert_allclose(found, best, atol=0.01)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)


def test_the_same_file_is_in_its_place(bumpy: Mesh, sample: SurfaceSample) -> None:
    frame = frame_between(sample, sample)
    assert (frame.scale, frame.translation.tolist()) == (1, [0, 0, 0])
    assert fit_surface(Surface(bumpy, sample), sample, sample, frame, steps=False).deviation < 1e-9


@pytest.mark.parametrize("scale", [1.0, 2.5])
def test_a_moved_copy_comes_back_exactly(bumpy: Mesh, sample: SurfaceSample, scale: float) -> None:
    """From a start that is a little off, to the motion that was made: other points of the same surface."""
    turn = Rotation.from_euler("xyz", [0.4, -1.0, 2.0]).as_matrix()
    order = np.random.default_rng(0).permutation(len(bumpy.faces))
    moved = Mesh(scale * bumpy.vertices @ turn.T + [3, 4, 5], bumpy.faces[order])
    candidate = sampled(moved)
    there = frame_between(sample, candidate)
    off = Rotation.from_rotvec([0.03, -0.02, 0.04]).as_matrix()
    # The candidate's units, back through the motion, to the query's.
    shift = (np.array([3, 4, 5]) + scale * turn @ sample.center - candidate.center) / candidate.unit
    exact = Frame(scale * sample.unit / candidate.unit, turn, shift).inverse()
    found = fit_surface(
        Surface(bumpy, sample),
        sample,
        candidate,
        Frame(1.02 * exact.scale, off @ exact.rotation, exact.translation),
    )
    assert there.scale == pytest.approx(scale, rel=1e-6)
    assert found.deviation < 1e-6
    np.testing.assert_allclose(found.frame.rotation, exact.rotation, atol=1e-5)
    np.testing.assert_allclose(found.frame.translation, exact.translation, atol=1e-5)
    assert found.frame.scale == pytest.approx(exact.scale, rel=1e-5)
    assert found.covered(1e-4) == 1
    assert found.query_covered > 0.97


def test_what_is_missing_is_not_covered(bumpy: Mesh, sample: SurfaceSample) -> None:
    keep = bumpy.vertices[bumpy.faces].mean(axis=1)[:, 2] < 0
    used, corners = np.unique(bumpy.faces[keep], return_inverse=True)
    part = Mesh(bumpy.vertices[used], corners.reshape(-1, 3).astype(np.int32))
    candidate = sampled(part)
    found = fit_surface(
        Surface(bumpy, sample), sample, candidate, frame_between(sample, candidate), steps=False
    )
    assert found.deviation < 1e-6
    assert found.query_covered == pytest.approx(part.area / bumpy.area, abs=0.15)  # up to a spacing beyond it


def test_twice_mirrored_is_the_sample_again(sample: SurfaceSample) -> None:
    again = mirrored(mirrored(sample))
    np.testing.assert_array_equal(again.points, sample.points)
    np.testing.assert_array_equal(again.centers, sample.centers)
    assert mirrored(sample).descriptors is sample.descriptors


def test_the_best_frame_is_the_one_with_the_least_distance(bumpy: Mesh, sample: SurfaceSample) -> None:
    surface, random = Surface(bumpy, sample), np.random.default_rng(5)
    near = [Frame(1.0, np.eye(3), 0.01 * random.normal(size=3)) for _ in range(3)]
    turned = [Frame(1.0, turn.as_matrix(), np.zeros(3)) for turn in Rotation.random(3, random)]
    frames = [*turned, *near]
    distances = [measured(surface, sample, frame) for frame in frames]
    assert best_frame(surface, sample, frames) is frames[int(np.argmin(distances))]
