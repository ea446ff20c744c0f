# SPDX-License-Identifier: MIT
"""Invariances that all descriptors of the mesh share, and their refusals."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapegoogle_core.descriptors import (
    geodesic_histograms,
    mesh_hog,
    shape_contexts,
    vertex_spin_images,
    volumetric_hks,
)
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, MeshLike
from shapegoogle_core.mesh.mesh import FloatArray
from tests.core.conftest import Shapes

HISTOGRAMS: dict[str, Callable[..., np.ndarray]] = {
    "spin image": vertex_spin_images,
    "shape context": shape_contexts,
    "geodesic histogram": geodesic_histograms,
    "mesh HOG": mesh_hog,
}


@pytest.mark.parametrize("name", HISTOGRAMS)
@pytest.mark.parametrize("seed", range(3))
def test_rigid_motion_size_and_order_do_not_matter(bumpy: Mesh, name: str, seed: int) -> None:
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
def test_a_mirror_image_and_normals_to_the_other_side_do_not_matter(bumpy: Mesh, name: str) -> None:
    mirrored = Mesh(bumpy.vertices * [-1, 1, 1], bumpy.faces)  # its normals point inwards
    difference = np.abs(HISTOGRAMS[name](mirrored) - HISTOGRAMS[name](bumpy)) > 1e-6
    assert difference.any(axis=1).mean() < 0.02


@pytest.mark.parametrize(("name", "spread"), [("spin image", 0.02), ("shape context", 0.02)])
def test_all_points_of_a_sphere_are_alike(shapes: type[Shapes], name: str, spread: float) -> None:
    values = HISTOGRAMS[name](shapes.sphere(4))
    assert values.max() > 0.05
    assert values.std(axis=0).max() < spread


@pytest.mark.parametrize(
    ("describe", "options", "message"),
    [
        (vertex_spin_images, {"radius": 0.0}, "radius must be a positive"),
        (vertex_spin_images, {"bins": (0, 3)}, "bins must be at least 1, not 0 × 3"),
        (shape_contexts, {"inner": 1.0, "outer": 0.5}, "radii inner and outer must"),
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
def test_refuses_parameters_out_of_range(
    shapes: type[Shapes], describe: Callable[..., np.ndarray], options: dict[str, object], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        describe(shapes.sphere(1), **options)


SURFACE_DESCRIPTORS: dict[str, Callable[[MeshLike], FloatArray]] = {
    "geodesic_histograms": geodesic_histograms,
    "mesh_hog": mesh_hog,
    "shape_contexts": shape_contexts,
    "vertex_spin_images": vertex_spin_images,
    "volumetric_hks": lambda mesh: volumetric_hks(mesh, [0.1]),
}


@pytest.mark.parametrize("name", SURFACE_DESCRIPTORS)
def test_refuses_what_is_not_a_clean_surface(shapes: type[Shapes], name: str) -> None:
    sphere = shapes.sphere(1)
    far = np.concatenate([sphere.vertices, [[2.0, 0.0, 0.0]]])
    flat = np.concatenate([sphere.faces, [[42, 42, 42]]])
    cases: list[tuple[MeshLike, str]] = [
        ((sphere.vertices, None), "no faces and 42 points"),
        ((0 * sphere.vertices, sphere.faces), "coincide"),
        ((far, sphere.faces), r"has 1 vertex that no face uses; repair it first"),
        ((far, flat), "vertices without area; repair it first"),
    ]
    for shape, message in cases:
        with pytest.raises(MeshError, match=message):
            SURFACE_DESCRIPTORS[name](shape)
