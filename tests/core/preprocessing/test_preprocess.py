# SPDX-License-Identifier: MIT
"""Mending as a whole: on shapes with known faults, and on real files."""

from __future__ import annotations

from dataclasses import FrozenInstanceError

import numpy as np
import pytest
import trimesh

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, read_mesh, unique_edges
from shapegoogle_core.preprocessing import Mending, mend

BALL = trimesh.creation.icosphere(subdivisions=5)


def bumpy_ball() -> Mesh:
    x, y, z = BALL.vertices.T
    return Mesh(BALL.vertices * (1 + 0.3 * np.sin(3 * x) * np.cos(3 * y + z))[:, None], BALL.faces, "ball")


def noisy(mesh: Mesh, strength: float) -> Mesh:
    """Noise in every coordinate, as a share of the mean edge."""
    edges, _ = unique_edges(mesh)
    edge = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1).mean()
    noise = np.random.default_rng(0).normal(size=mesh.vertices.shape)
    return Mesh(mesh.vertices + strength * edge * noise, mesh.faces, mesh.name)


def test_defaults():
    assert Mending() == Mending(close_holes=0.45, floor=1000, budget=5000, smoothing=3e-4)
    with pytest.raises(FrozenInstanceError):
        Mending().floor = 7


def test_resolution_and_noise_hardly_matter():
    """Area within 2 % of the mended clean shape for a soup, noise, holes and fewer vertices."""
    clean = bumpy_ball()
    expected = mend(clean, Mending())
    soup = Mesh(clean.vertices[clean.faces].reshape(-1, 3), np.arange(3 * len(clean.faces)).reshape(-1, 3))
    holes = ~np.isin(clean.faces, np.random.default_rng(0).choice(len(clean.vertices), 300)).any(axis=1)
    coarse = mend(clean, Mending(budget=1500, smoothing=0))
    for variant in (soup, noisy(clean, 0.3), Mesh(clean.vertices, clean.faces[holes]), coarse):
        mended = mend(variant, Mending())
        assert 1000 <= len(mended.vertices) <= 5000
        assert (unique_edges(mended)[1] == 2).all()
        assert mended.area == pytest.approx(expected.area, rel=0.02)
    assert noisy(clean, 0.3).area > 1.2 * clean.area


def test_nothing_asked_for_nothing_done():
    clean = bumpy_ball()
    assert mend(clean, Mending(close_holes=0, floor=0, budget=20_000, smoothing=0)) is clean


def test_no_surface_before_or_after_repair():
    with pytest.raises(MeshError, match="'cloud' has no faces"):
        mend(Mesh(BALL.vertices, name="cloud"), Mending())
    crumbs = (np.random.default_rng(0).uniform(0, 1, (1000, 1, 3)) + np.zeros((3, 1))).reshape(-1, 3)
    crumbs[0] += 1e-4
    with pytest.raises(MeshError, match="'crumbs'"):
        mend(Mesh(crumbs, np.arange(3000).reshape(-1, 3), "crumbs"), Mending())


@pytest.mark.parametrize("shape", [trimesh.creation.box(), trimesh.creation.cylinder(0.01, 1, sections=6)])
def test_low_poly_props_reach_the_floor(shape):
    mended = mend(Mesh(shape.vertices, shape.faces), Mending())
    assert len(mended.vertices) >= 1000
    assert (unique_edges(mended)[1] == 2).all()


@pytest.mark.real_data
@pytest.mark.parametrize("pattern", ["psb/m1[0-2]*.ply", "tosca/*0.ply", "tosca_remeshed/*_01.ply"])
def test_real_meshes(pattern, data_folder):
    """Polygon soup, open boundaries, thousands of parts: all are mended, and something is left of each."""
    paths = sorted(data_folder.glob(pattern))
    assert paths
    for path in paths[:20]:
        mesh = read_mesh(path)
        mended = mend(mesh, Mending())
        assert len(mended.vertices) >= 1000, path.name
        assert mended.area > 0.2 * mesh.area, path.name
