# SPDX-License-Identifier: MIT
"""A part lies exactly on its whole, whatever its mesh; on a relative it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.creatures import make_creature
from benchmarks.experiments.evidence_pairs import cut
from shapegoogle_core import Mesh, compute_spectrum
from shapegoogle_core.preprocessing.resampling import simplify
from shapegoogle_core.preprocessing.subdivision import subdivide
from shapegoogle_core.registration import PreparedSample, SampleSettings, sample_surface
from shapegoogle_core.registration.fit.exact_fit import fit_exactly
from shapegoogle_core.registration.fit.rough_pose import rough_poses, rough_poses_back
from shapegoogle_core.registration.frames import Frame
from shapegoogle_core.registration.prepared_sample import SHARED_SCALES

KINDS = ("dog", "bird", "horse", "human")


def prepared(mesh: Mesh) -> PreparedSample:
    scaled = Mesh(mesh.vertices / np.sqrt(mesh.area), mesh.faces)
    return PreparedSample(
        sample_surface(scaled, compute_spectrum(scaled, 40), SampleSettings()), SHARED_SCALES
    )


@pytest.fixture(scope="module", params=KINDS)
def shapes(request: pytest.FixtureRequest) -> tuple[PreparedSample, PreparedSample, PreparedSample]:
    """A half, turned and of another mesh; its whole; a relative."""
    mesh = make_creature(request.param, 201, vertex_count=3000).rest
    half = cut(mesh, np.array([0.3, 1.0, 0.5]), 0.5)
    half = simplify(subdivide(half, 3 * len(half.vertices)), len(half.vertices))
    turn = Rotation.random(random_state=3).as_matrix()
    relative = make_creature(request.param, 202, vertex_count=3000).rest
    return prepared(Mesh(half.vertices @ turn.T, half.faces)), prepared(mesh), prepared(relative)


def test_a_half_lies_exactly_on_its_whole_alone(
    shapes: tuple[PreparedSample, PreparedSample, PreparedSample],
) -> None:
    half, whole, relative = shapes
    every = range(len(half.scales))
    pose, other = rough_poses(half, [whole.sample, relative.sample], [every, every])
    assert pose.frame is not None
    assert pose.covered > 0.5
    exact, frame = fit_exactly(half, whole, pose.frame)
    assert exact > 0.7
    assert frame.scale == pytest.approx(np.sqrt(0.5), rel=0.02)  # both are of unit area
    if other.frame is not None:
        assert fit_exactly(half, relative, other.frame)[0] < exact - 0.15


def test_a_whole_knows_where_its_half_lies(
    shapes: tuple[PreparedSample, PreparedSample, PreparedSample],
) -> None:
    half, whole, relative = shapes
    pose, _ = rough_poses_back(whole, [half.sample, relative.sample], [0.85, 0.7, 0.6])
    assert pose.frame is not None
    assert pose.frame.scale == pytest.approx(np.sqrt(2), rel=0.1)
    exact, frame = fit_exactly(half, whole, pose.frame.inverse())
    assert exact > 0.7
    assert frame.scale == pytest.approx(np.sqrt(0.5), rel=0.02)


def test_spheres_of_other_points_fit_to_a_thousandth() -> None:
    """Tangent planes would be 0.003 apart and more; the scale comes right from 5 % away."""
    random = np.random.default_rng(0)
    spheres = []
    for _ in range(2):
        points = random.normal(size=(4000, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        spheres.append(points)
    base = prepared(make_creature("dog", 201, vertex_count=1000).rest)
    radius = 0.28  # of unit area
    first, second = (
        PreparedSample(replace(base.sample, points=radius * points[:600], normals=points[:600]))
        for points in spheres
    )
    exact, frame = fit_exactly(first, second, Frame(1.05, np.eye(3), np.array([0.01, 0.0, 0.02])))
    assert exact > 0.99
    assert frame.scale == pytest.approx(1, abs=2e-3)
    assert np.abs(frame.translation).max() < 2e-3


def test_what_has_nothing_in_common() -> None:
    base = prepared(make_creature("dog", 201, vertex_count=1000).rest)
    exact, frame = fit_exactly(base, base, Frame(1.0, np.eye(3), np.array([50.0, 0, 0])))
    assert exact == 0
    assert frame.translation[0] == 50
