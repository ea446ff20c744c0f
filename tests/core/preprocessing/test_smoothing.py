# SPDX-License-Identifier: MIT
"""Smoothing: what the equation says, on surfaces where it can be solved by hand."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from shapegoogle_core.mesh import Mesh, unique_edges
from shapegoogle_core.preprocessing import repair, smooth

BALLS = {n: trimesh.creation.icosphere(subdivisions=n) for n in (3, 4, 5)}


def ball(subdivisions: int) -> Mesh:
    return Mesh(BALLS[subdivisions].vertices, BALLS[subdivisions].faces)


@pytest.mark.parametrize("subdivisions", BALLS)
@pytest.mark.parametrize("time", [1e-3, 1e-2])
def test_sphere_shrinks_as_the_equation_says(subdivisions: int, time: float) -> None:
    """The coordinates of a unit sphere are eigenfunctions of eigenvalue 2; its area is 4π."""
    after = smooth(ball(subdivisions), time)
    radius = np.linalg.norm(after.vertices, axis=1)
    assert radius == pytest.approx(1 / (1 + (8 * np.pi * time) ** 2), rel=5e-3)


def sheet(cells: int) -> Mesh:
    """The unit square, flat."""
    x, y = np.meshgrid(np.linspace(0, 1, cells + 1), np.linspace(0, 1, cells + 1))
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    right, above, across = corner + 1, corner + cells + 1, corner + cells + 2
    faces = np.concatenate([np.stack([corner, right, across], 1), np.stack([corner, across, above], 1)])
    return Mesh(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), faces)


@pytest.mark.parametrize("cells", [24, 48, 96])
@pytest.mark.parametrize("waves", [1, 2, 3])
@pytest.mark.parametrize("time", [1e-3, 1e-2])
def test_waves_are_damped_by_their_length(cells: int, waves: int, time: float) -> None:
    """Low waves on a square of area 1, at every resolution; they vanish on the boundary, which stays."""
    flat = sheet(cells)
    x, y, _ = flat.vertices.T
    wave = np.sin(np.pi * waves * x) * np.sin(np.pi * waves * y)
    after = smooth(Mesh(flat.vertices + 1e-3 * wave[:, None] * [0, 0, 1], flat.faces), time)
    amplitude = after.vertices[:, 2] @ wave / (wave @ wave) / 1e-3
    assert amplitude == pytest.approx(1 / (1 + (time * 2 * (np.pi * waves) ** 2) ** 2), rel=0.05)


def test_units_position_and_direction_do_not_matter() -> None:
    turn = trimesh.transformations.random_rotation_matrix(np.array([0.1, 0.5, 0.9]))[:3, :3]
    rng = np.random.default_rng(0)
    base = ball(3)
    noisy = Mesh(base.vertices + rng.normal(size=base.vertices.shape) * 0.03, base.faces)
    expected = smooth(noisy, 1e-3).vertices
    for unit in (1e-6, 1e6):
        moved = smooth(Mesh((noisy.vertices @ turn.T + 5) * unit, noisy.faces), 1e-3)
        assert np.allclose((moved.vertices / unit - 5) @ turn, expected, atol=1e-8)


def test_noise_goes_and_shape_stays() -> None:
    rng = np.random.default_rng(0)
    base = ball(4)
    noisy = Mesh(base.vertices + rng.normal(size=base.vertices.shape) * 0.02, base.faces)
    after = smooth(noisy, 3e-4)
    before_error, error = (np.std(np.linalg.norm(each.vertices, axis=1)) for each in (noisy, after))
    assert error < 0.4 * before_error
    assert after.area == pytest.approx(base.area, rel=0.02)


def test_time_zero_and_negative() -> None:
    mesh = ball(3)
    assert smooth(mesh, 0) is mesh
    with pytest.raises(ValueError, match="negative"):
        smooth(mesh, -1e-4)


def test_boundary_stays_and_flat_sheets_stay_flat() -> None:
    rng = np.random.default_rng(0)
    flat, faces = sheet(20).vertices + 3, sheet(20).faces
    edges, counts = unique_edges(Mesh(flat, faces))
    boundary = np.unique(edges[counts == 1])
    inner = np.setdiff1d(np.arange(len(flat)), boundary)
    assert np.allclose(smooth(Mesh(flat, faces), 1e-2).vertices, flat)
    bumpy = flat.copy()
    bumpy[inner, 2] += rng.normal(size=len(inner)) * 0.02
    after = smooth(Mesh(bumpy, faces), 1e-2)
    assert np.array_equal(after.vertices[boundary], bumpy[boundary])
    assert np.std(after.vertices[inner, 2]) < 0.2 * np.std(bumpy[inner, 2])


def test_parts_are_smoothed_as_if_alone() -> None:
    small = ball(3).vertices * 0.05 + 3
    both = Mesh(
        np.concatenate([ball(3).vertices, small]), np.concatenate([ball(3).faces, ball(3).faces + 642])
    )
    after = smooth(both, 1e-3)
    alone = smooth(Mesh(small, ball(3).faces), 1e-3)
    assert np.allclose(after.vertices[642:], alone.vertices)
    assert np.allclose(after.vertices[:642], smooth(ball(3), 1e-3).vertices)


def test_needles_and_caps() -> None:
    """Faces of almost no area next to good ones: finite, and within the shape."""
    box = trimesh.creation.box()
    vertices = np.concatenate([box.vertices, [(box.vertices[0] + box.vertices[1]) / 2 + 1e-13]])
    faces = np.concatenate([box.faces, [[0, 1, 8]]])
    after = smooth(Mesh(vertices, faces), 1e-3)
    assert np.abs(after.vertices).max() <= 0.6


@settings(max_examples=100, deadline=None)
@given(
    st.lists(
        st.tuples(*[st.integers(0, 11)] * 3).filter(lambda f: len(set(f)) == 3), min_size=1, max_size=40
    ),
    st.floats(1e-6, 1),
    st.integers(0, 2**32 - 1),
)
def test_never_fails_on_soup(faces: list[tuple[int, ...]], time: float, seed: int) -> None:
    vertices = np.random.default_rng(seed).uniform(-1, 1, (12, 3))
    mesh = repair(Mesh(vertices, faces))
    after = smooth(mesh, time)
    assert np.isfinite(after.vertices).all()
    assert np.array_equal(after.faces, mesh.faces)
    assert np.abs(after.vertices).max() < 4
