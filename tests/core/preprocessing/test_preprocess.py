# SPDX-License-Identifier: MIT
"""Preprocessing as a whole: on shapes with known faults, and on real files."""

from __future__ import annotations

from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, read_mesh, unique_edges
from shapegoogle_core.preprocessing import PreprocessingSettings, preprocess

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


def test_defaults() -> None:
    assert PreprocessingSettings() == PreprocessingSettings(
        close_holes=0.45, floor=1000, budget=5000, longest_edge=0.045, smoothing=3e-4
    )
    with pytest.raises(FrozenInstanceError):
        PreprocessingSettings().floor = 7  # type: ignore[misc]


def test_resolution_and_noise_hardly_matter() -> None:
    """Area within 2 % of the preprocessed clean shape for a soup, noise, holes and fewer vertices."""
    clean = bumpy_ball()
    expected = preprocess(clean, PreprocessingSettings())
    soup = Mesh(clean.vertices[clean.faces].reshape(-1, 3), np.arange(3 * len(clean.faces)).reshape(-1, 3))
    holes = ~np.isin(clean.faces, np.random.default_rng(0).choice(len(clean.vertices), 300)).any(axis=1)
    coarse = preprocess(clean, PreprocessingSettings(budget=1500, smoothing=0))
    for variant in (soup, noisy(clean, 0.3), Mesh(clean.vertices, clean.faces[holes]), coarse):
        after = preprocess(variant, PreprocessingSettings())
        assert 1000 <= len(after.vertices) <= 5000
        assert (unique_edges(after)[1] == 2).all()
        assert after.area == pytest.approx(expected.area, rel=0.02)
    assert noisy(clean, 0.3).area > 1.2 * clean.area


def test_nothing_asked_for_nothing_done() -> None:
    clean = bumpy_ball()
    nothing = PreprocessingSettings(close_holes=0, floor=0, budget=20_000, longest_edge=0, smoothing=0)
    assert preprocess(clean, nothing) is clean


def test_no_surface_before_or_after_repair() -> None:
    with pytest.raises(MeshError, match="'points' has no faces and 9 points"):
        preprocess(Mesh(BALL.vertices[:9], name="points"))
    crumbs = (np.random.default_rng(0).uniform(0, 1, (1000, 1, 3)) + np.zeros((3, 1))).reshape(-1, 3)
    crumbs[0] += 1e-4
    with pytest.raises(MeshError, match="'crumbs'"):
        preprocess(Mesh(crumbs, np.arange(3000).reshape(-1, 3), "crumbs"), PreprocessingSettings())


def test_a_point_cloud_is_welded_thinned_and_smoothed() -> None:
    noise = np.random.default_rng(0).normal(size=BALL.vertices.shape)
    points = np.repeat(BALL.vertices + 0.02 * noise, 2, axis=0)
    after = preprocess(Mesh(points, name="cloud"), PreprocessingSettings(budget=2000))
    assert after.is_point_cloud
    assert after.name == "cloud"
    assert 1800 < len(after.vertices) <= 2000
    assert np.linalg.norm(after.vertices, axis=1).std() < 0.01
    untouched = PreprocessingSettings(budget=20_000, smoothing=0)
    assert np.array_equal(preprocess(Mesh(points), untouched).vertices, points[::2])


def test_points_that_crowd_in_few_places_are_refused() -> None:
    places = np.repeat(np.random.default_rng(0).normal(size=(5, 3)), 100, axis=0)
    crowd = places + 4e-6 * np.random.default_rng(1).normal(size=places.shape)
    with pytest.raises(MeshError, match=r"'crowd' has no faces and \d points"):
        preprocess(Mesh(crowd, name="crowd"), PreprocessingSettings(budget=20))


def test_any_kind_of_mesh_is_taken() -> None:
    expected = preprocess(bumpy_ball())
    for shape in ((bumpy_ball().vertices, BALL.faces), trimesh.Trimesh(bumpy_ball().vertices, BALL.faces)):
        assert np.array_equal(preprocess(shape).vertices, expected.vertices)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("close_holes", -0.1),
        ("close_holes", 2.0),
        ("floor", -1),
        ("budget", 3),
        ("longest_edge", -1.0),
        ("smoothing", np.inf),
    ],
)
def test_settings_out_of_range_are_named(name: str, value: float) -> None:
    wrong: dict[str, Any] = {name: value}
    with pytest.raises(ValueError, match=f"{name} must be a .*number.*, not {value}"):
        PreprocessingSettings(**wrong)


@pytest.mark.parametrize("shape", [trimesh.creation.box(), trimesh.creation.cylinder(0.01, 1, sections=6)])
def test_low_poly_props_reach_the_floor(shape: trimesh.Trimesh) -> None:
    after = preprocess(Mesh(shape.vertices, shape.faces), PreprocessingSettings())
    assert len(after.vertices) >= 1000
    assert (unique_edges(after)[1] == 2).all()


@pytest.mark.real_data
@pytest.mark.parametrize("pattern", ["psb/m1[0-2]*.ply", "tosca/*0.ply", "tosca_remeshed/*_01.ply"])
def test_real_meshes(pattern: str, data_folder: Path) -> None:
    """Polygon soup, open boundaries, thousands of parts: something is left of each."""
    paths = sorted(data_folder.glob(pattern))
    assert paths
    for path in paths[:8]:
        mesh = read_mesh(path)
        after = preprocess(mesh, PreprocessingSettings())
        assert len(after.vertices) >= 1000, path.name
        assert after.area > 0.2 * mesh.area, path.name
