# SPDX-License-Identifier: MIT
"""Local heat is what theory says, forgets pose and place, and knows how far it is from a cut."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapegoogle_core import Mesh, PreprocessingSettings, load_model
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.preprocessing import preprocess, preprocess_in_steps
from shapegoogle_core.registration import (
    LocalHeat,
    SampleSettings,
    SurfaceSample,
    farthest_points,
    sample_surface,
)
from shapegoogle_core.registration.heat.local_heat import HEAT_TIMES
from tests.core.conftest import Shapes

FARTHEST = 0.75
SETTINGS = load_model().settings


def sample_of(mesh: Mesh) -> SurfaceSample:
    shape = working_shape(SETTINGS, mesh)
    sample = sample_surface(shape.mesh, shape.spectrum, SampleSettings(), shape.unsmoothed)
    return sample.moved_back(shape.placement.origin, shape.placement.scale)


def heat_of(mesh: Mesh) -> LocalHeat:
    heat = sample_of(mesh).local_heat
    assert heat is not None
    return heat


def sphere_heat(times: np.ndarray) -> np.ndarray:
    """Log 4πt K_t(x, x) on a sphere of unit area: eigenvalues l (l + 1) / r², each 2 l + 1 times."""
    degree = np.arange(200.0)
    decay = np.exp(-np.outer(times, degree * (degree + 1) * 4 * np.pi))
    return np.asarray(np.log(4 * np.pi * times * (decay @ (2 * degree + 1))))


@pytest.fixture(scope="module")
def sphere(shapes: type[Shapes]) -> Mesh:
    return shapes.sphere(4)


@pytest.fixture(scope="module")
def cap(sphere: Mesh) -> Mesh:
    """A sphere without what lies above z = 0.4."""
    inside = (sphere.vertices[sphere.faces][:, :, 2] < 0.4).all(axis=1)
    return Mesh(sphere.vertices, sphere.faces[inside])


def test_on_a_sphere_it_is_that_of_the_sphere(sphere: Mesh) -> None:
    heat = heat_of(sphere)
    expected = sphere_heat(HEAT_TIMES)
    np.testing.assert_allclose(heat.values, np.broadcast_to(expected, heat.values.shape), atol=0.05)
    np.testing.assert_allclose(np.exp(heat.radii), 1 / np.sqrt(4 * np.pi), rtol=0.15)
    assert not heat.is_cut
    np.testing.assert_allclose(heat.margins, FARTHEST, atol=1e-6)


@pytest.mark.parametrize("scale", [1.0, 0.9, 0.75, 0.6])
def test_at_another_size_it_is_that_at_other_times(scale: float, sphere: Mesh) -> None:
    heat = heat_of(sphere)
    values, radii, margins = heat.at_scale(scale)
    times = np.minimum(HEAT_TIMES / scale**2, HEAT_TIMES[-1])
    np.testing.assert_allclose(values, np.broadcast_to(sphere_heat(times), values.shape), atol=0.06)
    np.testing.assert_allclose(radii - heat.radii, np.log(scale), atol=1e-6)
    np.testing.assert_allclose(margins, scale * heat.margins, rtol=1e-6)


def test_on_a_plane_it_is_zero_far_from_the_edge(shapes: type[Shapes]) -> None:
    heat = heat_of(shapes.rectangle(1.0, 1.0, 60))
    inside = heat.margins > 0.3
    assert 20 < inside.sum() < 400
    # e^(-0.3² / 0.008) of it comes back from the edge.
    np.testing.assert_allclose(heat.values[inside, :2], 0, atol=0.05)


def test_it_knows_how_far_it_is_from_a_cut(cap: Mesh) -> None:
    sample = sample_of(cap)
    heat = sample.local_heat
    assert heat is not None
    assert heat.is_cut
    points = sample.center + sample.unit * sample.points
    rim = np.arccos(cap.vertices[np.unique(cap.faces), 2].max())
    polar = np.arccos(np.clip(points[:, 2] / np.linalg.norm(points, axis=1), -1, 1))
    # Along the surface, in units of √area; a lid over the hole is as far as none.
    expected = np.clip((polar - rim) / np.sqrt(cap.area), 0, FARTHEST)
    measured = heat.margins[: len(points)]
    on_cap = polar > rim + 0.1
    difference = measured[on_cap] - expected[on_cap]
    assert difference.min() > -0.05
    # Edges are up to 15 % longer than the way across the faces; a lid makes the area larger.
    assert (difference <= 0.2 * expected[on_cap] + 0.05).all()


def pierced(mesh: Mesh, height: float) -> Mesh:
    """Remove what lies above a height."""
    inside = (mesh.vertices[mesh.faces][:, :, 2] < height).all(axis=1)
    return Mesh(mesh.vertices, mesh.faces[inside])


def test_the_lid_of_a_large_hole_counts_as_cut(sphere: Mesh) -> None:
    opened = pierced(sphere, 0.9)  # 0.25 √area wide
    openings = preprocess_in_steps(opened, PreprocessingSettings()).unsmoothed.openings
    assert openings[:, 2].min() > 0.85, "on the rim and the lid, nowhere else"
    near_axis = np.linalg.norm(openings[:, :2], axis=1) < 0.2
    assert near_axis.sum() > 20, "on the lid"
    heat = heat_of(opened)
    assert heat.is_cut
    assert (heat.margins < 0.02).any()
    assert heat.margins.max() == pytest.approx(FARTHEST, abs=0.02)


def test_small_holes_cut_nothing_off(sphere: Mesh) -> None:
    opened = pierced(sphere, 0.97)  # 0.17 √area wide
    assert len(preprocess_in_steps(opened, PreprocessingSettings()).unsmoothed.openings) == 0
    heat = heat_of(opened)
    assert not heat.is_cut
    np.testing.assert_allclose(heat.margins, FARTHEST, atol=1e-6)


def test_many_small_holes_are_not_a_large_one(sphere: Mesh) -> None:
    """Holes are measured one by one: a scan can have a dozen."""
    corners = sphere.vertices[sphere.faces].mean(axis=1)
    centers = farthest_points(sphere.vertices, 12)
    near = np.linalg.norm(corners[:, None] - sphere.vertices[centers], axis=2).min(axis=1) < 0.2
    assert near.any()
    assert not heat_of(Mesh(sphere.vertices, sphere.faces[~near])).is_cut


def test_small_holes_count_where_something_is_cut_off(cap: Mesh) -> None:
    """The whole may not have them."""
    low = (cap.vertices[cap.faces][:, :, 2] < -0.98).any(axis=1)
    openings = preprocess_in_steps(Mesh(cap.vertices, cap.faces[~low])).unsmoothed.openings
    assert openings[:, 2].min() < -0.9


def test_steps_give_what_preprocessing_gives(cap: Mesh) -> None:
    steps, mesh = preprocess_in_steps(cap), preprocess(cap)
    np.testing.assert_array_equal(steps.mesh.vertices, mesh.vertices)
    np.testing.assert_array_equal(steps.mesh.faces, mesh.faces)
    assert len(steps.unsmoothed.mesh.vertices) == len(mesh.vertices)
    assert np.abs(steps.unsmoothed.mesh.vertices - mesh.vertices).max() > 0


def test_faces_that_lie_apart_are_no_part(shapes: type[Shapes]) -> None:
    """A polygon soup ends everywhere: what is missing of it cannot be told."""
    bumpy = shapes.bumpy(2)
    # Faces that are apart by more than welding joins.
    corners = bumpy.vertices[bumpy.faces]
    corners = corners + 0.1 * (corners.mean(axis=1, keepdims=True) - corners)
    soup = Mesh(corners.reshape(-1, 3), np.arange(3 * len(bumpy.faces)).reshape(-1, 3))
    assert not heat_of(soup).is_cut


def test_it_forgets_place_and_size(cap: Mesh) -> None:
    turn = Rotation.from_euler("xyz", [0.4, -1.1, 2.0]).as_matrix()
    one, other = heat_of(cap), heat_of(Mesh(7 * cap.vertices @ turn.T + [10, -3, 5], cap.faces))
    for before, after in ((one.values, other.values), (one.margins, other.margins)):
        np.testing.assert_allclose(np.sort(after, axis=0), np.sort(before, axis=0), atol=0.05)


def test_bytes_and_back(cap: Mesh) -> None:
    sample = sample_of(cap)
    heat = sample.local_heat
    assert heat is not None
    back = LocalHeat.from_bytes(heat.to_bytes())
    for name in ("values", "radii", "margins"):
        np.testing.assert_array_equal(getattr(back, name), getattr(heat, name))
    assert len(heat.to_bytes()) == 4 + 9 * 1200
    stored = SurfaceSample.from_bytes(sample.to_bytes()).local_heat
    assert stored is not None
    np.testing.assert_array_equal(stored.values, heat.values)


@pytest.mark.parametrize("damage", [b"", b"\0\0", b"\1\0\7\0" + bytes(8), b"\1\0\6\0" + bytes(8), bytes(30)])
def test_damaged_bytes_are_refused(damage: bytes) -> None:
    with pytest.raises(ValueError, match="local heat"):
        LocalHeat.from_bytes(damage)


def test_a_sample_from_before_has_none(cap: Mesh) -> None:
    sample = sample_of(cap)
    heat = sample.local_heat
    assert heat is not None
    old = sample.to_bytes().removesuffix(heat.to_bytes())
    assert len(old) < len(sample.to_bytes())
    assert SurfaceSample.from_bytes(old).local_heat is None


def test_points_without_faces_have_none(sphere: Mesh) -> None:
    shape = working_shape(SETTINGS, Mesh(sphere.vertices, np.empty((0, 3), np.int32)))
    sample = sample_surface(shape.mesh, shape.spectrum, SampleSettings(), shape.unsmoothed)
    assert sample.local_heat is None
