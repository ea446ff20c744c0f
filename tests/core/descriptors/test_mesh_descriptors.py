# SPDX-License-Identifier: MIT
"""Descriptors of the mesh against closed forms and plain loops, and the invariances that they claim."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from shapegoogle_core.descriptors import (
    geodesic_histograms,
    gradient_histograms,
    mean_curvature,
    mesh_hog,
    shape_contexts,
    vertex_spin_images,
    volumetric_hks,
)
from shapegoogle_core.descriptors.geodesics import geodesic_neighbors, surface_graph
from shapegoogle_core.descriptors.gradient_histograms import vertex_gradients
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.measures import face_areas, vertex_areas, vertex_normals

HISTOGRAMS: dict[str, Callable[..., np.ndarray]] = {
    "spin image": vertex_spin_images,
    "shape context": shape_contexts,
    "geodesic histogram": geodesic_histograms,
    "mesh HOG": mesh_hog,
}


def random_vertices(mesh: Mesh, count: int = 50) -> np.ndarray:
    return np.random.default_rng(0).choice(len(mesh.vertices), count, replace=False)


@pytest.mark.parametrize("name", HISTOGRAMS)
@pytest.mark.parametrize("seed", range(3))
def test_rigid_motion_size_and_order_do_not_matter(bumpy, name, seed):
    random = np.random.default_rng(seed)
    order = random.permutation(len(bumpy.vertices))
    points = 10.0 ** random.uniform(-3, 3) * (
        bumpy.vertices @ Rotation.random(rng=seed).as_matrix() + [1, 2, 3]
    )
    moved = Mesh(points[order], np.argsort(order)[bumpy.faces])
    before, after = HISTOGRAMS[name](bumpy)[order], HISTOGRAMS[name](moved)
    # What lies on the edge of two bins may fall to either side by rounding.
    changed = (np.abs(after - before) > 1e-6).any(axis=1)
    assert changed.mean() < 0.02


@pytest.mark.parametrize("name", HISTOGRAMS)
def test_a_mirror_image_and_normals_to_the_other_side_do_not_matter(bumpy, name):
    mirrored = Mesh(bumpy.vertices * [-1, 1, 1], bumpy.faces)  # its normals point inwards
    difference = np.abs(HISTOGRAMS[name](mirrored) - HISTOGRAMS[name](bumpy)) > 1e-6
    assert difference.any(axis=1).mean() < 0.02


@pytest.mark.parametrize(("name", "spread"), [("spin image", 0.02), ("shape context", 0.02)])
def test_all_points_of_a_sphere_are_alike(shapes, name, spread):
    values = HISTOGRAMS[name](shapes.sphere(4))
    assert values.max() > 0.05
    assert values.std(axis=0).max() < spread


def test_spin_images_by_a_loop(bumpy):
    radius, rows, columns = 0.3, 5, 3
    images = vertex_spin_images(bumpy, radius, (rows, columns))
    areas, normals, unit = vertex_areas(bumpy), vertex_normals(bumpy), np.sqrt(bumpy.area)
    for vertex in random_vertices(bumpy):
        expected = np.zeros((rows, columns))
        for other, area in enumerate(areas):
            offset = (bumpy.vertices[other] - bumpy.vertices[vertex]) / unit
            height = abs(offset @ normals[vertex])
            distance = np.linalg.norm(np.cross(offset, normals[vertex]))
            if height < radius and distance < radius:
                expected[int(distance / radius * rows), int(height / radius * columns)] += area
        np.testing.assert_allclose(images[vertex], expected.ravel() / expected.sum(), atol=1e-9)


def test_shape_contexts_by_a_loop(bumpy):
    edges, elevations = np.geomspace(0.1, 0.8, 4), 3
    contexts = shape_contexts(bumpy, 0.1, 0.8, shells=4, elevations=elevations)
    areas, normals, unit = vertex_areas(bumpy), vertex_normals(bumpy), np.sqrt(bumpy.area)
    for vertex in random_vertices(bumpy):
        expected = np.zeros((4, elevations))
        for other, area in enumerate(areas):
            if other != vertex:
                offset = (bumpy.vertices[other] - bumpy.vertices[vertex]) / unit
                shell = min(int((np.linalg.norm(offset) > edges).sum()), 3)
                cosine = abs(offset @ normals[vertex]) / np.linalg.norm(offset)
                expected[shell, int(cosine * elevations)] += area / unit**2
        np.testing.assert_allclose(contexts[vertex], expected.ravel(), atol=1e-9)
    np.testing.assert_allclose(contexts.sum(axis=1), 1 - areas / unit**2)


def test_the_surface_graph_of_a_plane_is_nearly_euclidean(shapes):
    mesh = shapes.rectangle(1.5, 1.0, 30)
    for chunk, center, neighbor, distance in geodesic_neighbors(mesh, 0.4):
        offsets = mesh.vertices[neighbor] - mesh.vertices[chunk][center]
        straight = np.linalg.norm(offsets, axis=1) / np.sqrt(mesh.area)
        assert (distance >= straight * (1 - 1e-9)).all()
        assert (distance <= straight * 1.09 + 1e-9).all()  # a grid of right angles: 1.082 between 45° and 90°
        inside = straight < 0.9 * 0.4
        assert distance[inside].sum() < 1.06 * straight[inside].sum()


def test_ways_across_an_edge_are_those_of_the_unfolded_triangles():
    for angle in (0.0, 0.5, 2.0):
        points = [[0, 0, 0], [0, 1, 0], [-0.5, 0.5, 0], [0.7 * np.cos(angle), 0.6, 0.7 * np.sin(angle)]]
        graph = surface_graph(Mesh(points, [[0, 1, 2], [1, 0, 3]])).toarray()
        assert graph[2, 3] == pytest.approx(np.hypot(1.2, 0.1))
    # Here the straight line misses the edge.
    points = [[0, 0, 0], [0, 1, 0], [-0.1, 5, 0], [0.1, 4, 0]]
    assert surface_graph(Mesh(points, [[0, 1, 2], [1, 0, 3]])).toarray()[2, 3] == 0


def test_geodesic_histogram_of_a_strip(shapes):
    # Along a narrow strip the way to a point is its distance along it: d bins end at r √(k/d) on both sides.
    strip = shapes.rectangle(10.0, 0.05, 2000)
    unit, radius, bins = np.sqrt(strip.area), 2.0, 4
    values = geodesic_histograms(strip, radius, bins)
    edges = radius * unit * np.sqrt(np.arange(bins + 1) / bins)
    expected = 2 * np.diff(edges) * 0.05 / (np.pi * (radius * unit) ** 2 / bins)
    middle = np.abs(strip.vertices[:, 0] - 5) < 5 - edges[-1] - 0.1
    assert middle.any()
    np.testing.assert_allclose(values[middle], np.tile(expected, (middle.sum(), 1)), rtol=0.05)
    end = strip.vertices[:, 0] == 0
    np.testing.assert_allclose(values[end], np.tile(expected / 2, (end.sum(), 1)), rtol=0.05)


def test_geodesic_histogram_of_a_sphere(shapes):
    # The cap within a distance s has the area 2πR² (1 - cos(s/R)), and here 4πR² = 1.
    values = geodesic_histograms(shapes.sphere(4), 0.4, 4)
    edges, radius = 0.4 * np.sqrt(np.arange(5) / 4), 1 / np.sqrt(4 * np.pi)
    expected = 2 * np.pi * radius**2 * np.diff(-np.cos(edges / radius)) / (np.pi * 0.4**2 / 4)
    np.testing.assert_allclose(values.mean(axis=0), expected, rtol=0.05)
    assert values.std(axis=0).max() < 0.05


def test_geodesic_histogram_forgets_a_fold(shapes):
    flat = shapes.rectangle(1.0, 1.0, 20)
    x, y, z = flat.vertices.T
    folded = Mesh(np.stack([np.abs(x - 0.5), y, z], axis=1), flat.faces)
    radius = 0.3871  # no way of the grid ends on the edge of two bins
    np.testing.assert_allclose(
        geodesic_histograms(folded, radius), geodesic_histograms(flat, radius), atol=1e-6
    )


def test_mean_curvature_of_sphere_and_plane(shapes):
    sphere = shapes.sphere(4)
    small = Mesh(0.1 * sphere.vertices, sphere.faces)
    # A function of eigenvalue 2/R², as the positions are, is divided by 1 + 2t/R² in a step of heat flow.
    for smoothing in (3e-3, 1e-2):
        expected = 10 / (1 + 8 * np.pi * smoothing)
        np.testing.assert_allclose(mean_curvature(small, smoothing), expected, rtol=0.01)
    plane = shapes.rectangle(1.0, 1.0, 20)
    assert mean_curvature(plane).max() < 1e-9  # no pull of the rim


def test_gradient_of_a_linear_function(shapes):
    mesh = shapes.rectangle(2.0, 1.0, 12)
    turned = Mesh(mesh.vertices @ Rotation.random(rng=1).as_matrix(), mesh.faces)
    slope = np.array([0.3, -2.0, 0.7])
    normal = vertex_normals(turned)[0]
    expected = slope - (slope @ normal) * normal  # along the surface
    gradients = vertex_gradients(turned, turned.vertices @ slope)
    np.testing.assert_allclose(gradients, np.tile(expected, (len(gradients), 1)), atol=1e-9)


def test_mesh_hog_points_along_the_gradient(shapes, monkeypatch):
    """Where a function rises evenly, all gradients lie along the axis, in all sectors alike."""
    mesh = shapes.rectangle(1.0, 1.0, 40)
    monkeypatch.setattr(gradient_histograms, "mean_curvature", lambda mesh, _: 100 * mesh.vertices[:, 0])
    values = mesh_hog(mesh, radius=0.2, sectors=4, orientations=8, floor=1e-6)
    middle = np.abs(mesh.vertices[:, :2] - 0.5).max(axis=1) < 0.25
    sectors = values[middle].reshape(-1, 4, 8)
    assert (sectors[:, :, 1:] == 0).all()
    np.testing.assert_allclose(sectors[:, :, 0], 0.5, atol=0.2)  # some points lie on an edge of two
    np.testing.assert_allclose(np.linalg.norm(values[middle], axis=1), 1)


def test_mesh_hog_fades_where_nothing_is(shapes):
    assert np.abs(mesh_hog(shapes.sphere(4))).max() < 0.05


def test_volumetric_hks_of_a_box():
    # In a box with closed walls the kernel is a product of cosine series.
    sides = np.array([0.5, 0.4, 0.3])
    box = trimesh.creation.box(sides).subdivide().subdivide()
    mesh = Mesh(box.vertices, box.faces)
    time, values = 0.02, volumetric_hks(mesh, [0.02, 5.0], resolution=40)
    cube = np.sqrt(mesh.area) / 40
    lengths = (np.ceil(sides / cube) + 0.5) * cube  # the walls are half a cube to one outside
    modes = np.arange(1, 30)
    phases = np.outer(mesh.vertices[0] / sides + 0.5, modes) * np.pi
    decay = np.exp(-((np.pi * modes / lengths[:, None]) ** 2) * time * mesh.area)
    expected = np.log((1 + 2 * (np.cos(phases) ** 2 * decay).sum(axis=1)).prod())
    assert values[0, 0] == pytest.approx(expected, abs=0.15)
    np.testing.assert_allclose(values[:, 1], 0, atol=1e-6)


def test_volumetric_hks_changes_little_with_a_rotation(bumpy):
    """The grid shows: on a nearly round shape, whose values differ little, by up to a quarter of that."""
    times = [0.01, 0.04]
    values = volumetric_hks(bumpy, times)
    moved = Mesh(7 * bumpy.vertices @ Rotation.random(rng=2).as_matrix() + 5, bumpy.faces)
    change = np.abs(volumetric_hks(moved, times) - values)
    assert (change.mean(axis=0) < 0.3 * values.std(axis=0)).all()


def test_volumetric_hks_of_sheets_and_of_parts_far_apart(shapes):
    sheet = shapes.rectangle(1.0, 1.0, 10)
    assert np.isfinite(volumetric_hks(sheet, [0.01])).all()
    sphere = shapes.sphere(2)
    vertices = np.concatenate([sphere.vertices, sphere.vertices + 1e4])
    apart = Mesh(vertices, np.concatenate([sphere.faces, sphere.faces + len(sphere.vertices)]))
    assert np.isfinite(volumetric_hks(apart, [0.01])).all()


def test_areas_and_normals_of_vertices(shapes, bumpy):
    np.testing.assert_allclose(vertex_areas(bumpy).sum(), face_areas(bumpy).sum())
    sphere = shapes.sphere(3)
    np.testing.assert_allclose(vertex_normals(sphere), sphere.vertices, atol=0.02)


@pytest.mark.parametrize(
    ("describe", "options", "message"),
    [
        (vertex_spin_images, {"radius": 0.0}, "radius must be a positive"),
        (vertex_spin_images, {"bins": (0, 3)}, "bins must be at least 1, not 0 × 3"),
        (shape_contexts, {"inner": 1.0, "outer": 0.5}, "radii must ascend"),
        (shape_contexts, {"shells": 0}, "shells and elevations must be at least 1"),
        (geodesic_histograms, {"radius": np.nan}, "radius must be a positive"),
        (geodesic_histograms, {"bins": 0}, "bins must be at least 1"),
        (mesh_hog, {"sectors": 0}, "sectors and orientations"),
        (mesh_hog, {"floor": 0.0}, "floor must be positive"),
        (mesh_hog, {"smoothing": -1.0}, "smoothing must be"),
        (volumetric_hks, {"times": [0.1], "resolution": 0}, "resolution and eigenpairs"),
        (volumetric_hks, {"times": [-0.1]}, "times must be"),
    ],
)
def test_refuses_parameters_out_of_range(shapes, describe, options, message):
    with pytest.raises(ValueError, match=message):
        describe(shapes.sphere(1), **options)
