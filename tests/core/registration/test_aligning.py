# SPDX-License-Identifier: MIT
"""Aligning many candidates at once: as if each were alone, and the best of them finely."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation
from threadpoolctl import threadpool_limits

from benchmarks.creatures import make_creature
from shapegoogle_core import Mesh, compute_spectrum
from shapegoogle_core.model.augmentation import transform
from shapegoogle_core.registration import (
    PreparedSample,
    SampleSettings,
    SurfaceSample,
    align_all,
    sample_surface,
)
from shapegoogle_core.registration.aligning.nearest_field import NearestField
from shapegoogle_core.registration.medial_axis import measure_axis


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """On matrices of this size more threads of BLAS only get in each other's way."""
    with threadpool_limits(1, user_api="blas"):
        yield


def sampled(mesh: Mesh, points: int = 600) -> SurfaceSample:
    settings = SampleSettings(points, min(192, points))
    return sample_surface(mesh, compute_spectrum(mesh, k=60), settings)


@pytest.fixture(scope="module")
def horse() -> Mesh:
    return make_creature("horse", 301, vertex_count=1500).rest


@pytest.fixture(scope="module")
def candidates(horse: Mesh) -> list[SurfaceSample]:
    others = [make_creature(kind, 301, vertex_count=1500).rest for kind in ("dog", "bird", "human")]
    # A point cloud may have fewer points than other samples.
    return [sampled(mesh) for mesh in (others[0], horse, *others[1:])] + [sampled(horse, 150)]


def test_a_swollen_shape_is_brought_back_to_its_size(horse: Mesh, candidates: list[SurfaceSample]) -> None:
    """The part that is not swollen is smaller than in the original, because both have unit area."""
    swollen = transform(horse, "local_scale", 4, seed=0)
    turn = Rotation.random(random_state=1).as_matrix()
    query = sampled(Mesh(swollen.vertices @ turn.T, swollen.faces))
    true_scale = np.sqrt(swollen.area / horse.area)
    assert true_scale > 1.15
    alignment = align_all(PreparedSample(query), candidates[:4])[1]
    assert alignment is not None
    assert alignment.frame.scale == pytest.approx(true_scale, rel=0.05)
    np.testing.assert_allclose(alignment.frame.rotation, turn.T, atol=0.1)


def test_no_alignment_depends_on_the_other_candidates(horse: Mesh, candidates: list[SurfaceSample]) -> None:
    query = PreparedSample(sampled(transform(horse, "noise", 2, seed=0)))
    together = align_all(query, candidates)
    for place, candidate in enumerate(candidates):
        (alone,) = align_all(query, [candidate])
        found = together[place]
        assert alone is not None
        assert found is not None
        assert (found.agreement, found.frame.scale) == (alone.agreement, alone.frame.scale)
    agreements = [found.agreement for found in together if found is not None]
    assert sorted(np.argsort(agreements)[-2:].tolist()) == [1, 4]


def test_only_the_most_promising_are_aligned_finely(horse: Mesh, candidates: list[SurfaceSample]) -> None:
    query = PreparedSample(sampled(transform(horse, "noise", 2, seed=0)))
    every, best = align_all(query, candidates), align_all(query, candidates, finely=2)
    assert [place for place, found in enumerate(best) if found is not None] == [1, 4]
    assert all(best[place].frame.scale == every[place].frame.scale for place in (1, 4))  # type: ignore[union-attr]
    assert align_all(query, candidates, finely=0) == [None] * 5
    assert align_all(query, []) == []


def test_the_field_finds_what_a_tree_finds(candidates: list[SurfaceSample]) -> None:
    points = candidates[0].points
    places = points[:200] + np.random.default_rng(0).normal(size=(200, 3)) * 0.02
    field = NearestField(points)
    nearest = field.nearest(places.astype(np.float32))
    distances, _ = cKDTree(points).query(places)
    # Exact for the middle of a voxel, so at most its diagonal farther.
    assert (np.linalg.norm(field.points[nearest] - places, axis=1) <= distances + 0.03 * np.sqrt(3)).all()
    far = np.array([[50.0, 0, 0], [0, -50, 0], [1e9, 1e9, 1e9]], np.float32)
    assert (field.nearest(far) == len(points)).all()


def test_an_axis_keeps_its_size_where_a_limb_swells(horse: Mesh, candidates: list[SurfaceSample]) -> None:
    swollen = sampled(transform(horse, "local_scale", 4, seed=0))
    axis, other = measure_axis(candidates[1]), measure_axis(swollen)
    assert axis.size * candidates[1].unit == pytest.approx(other.size * swollen.unit, rel=0.12)
    np.testing.assert_allclose(axis.axes @ axis.axes.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(axis.axes) == pytest.approx(1)
