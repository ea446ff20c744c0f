# SPDX-License-Identifier: MIT
"""Previews are small, look like their shapes, and damaged ones are refused."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from shapegoogle_core.mesh import Mesh, as_mesh
from shapegoogle_core.rendering import make_preview, read_preview


def soup(count: int) -> Mesh:
    random = np.random.default_rng(0)
    corners = random.random((count, 1, 3)) + 0.05 * random.standard_normal((count, 3, 3))
    return Mesh(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


@pytest.mark.parametrize(
    "mesh",
    [
        as_mesh(trimesh.creation.box((1e-4, 2e-4, 3e-4))),
        as_mesh(trimesh.creation.icosphere(5, radius=1e5)),
        as_mesh(trimesh.creation.torus(2, 0.3, major_sections=200, minor_sections=60)),
        soup(30_000),
        Mesh(np.random.default_rng(0).random((20_000, 3)), np.empty((0, 3), np.int32)),
    ],
    ids=["tiny box", "huge ball", "torus", "soup", "points"],
)
def test_a_preview_is_small_and_near_its_shape(mesh: Mesh) -> None:
    content = make_preview(mesh)
    assert content is not None
    assert len(content) <= 15_000
    small = read_preview(content).mesh
    assert small.is_point_cloud == mesh.is_point_cloud
    assert len(small.faces) <= 2_000
    away, _ = cKDTree(mesh.vertices).query(small.vertices)
    assert np.max(away) <= 0.05 * np.linalg.norm(np.ptp(mesh.vertices, axis=0))


def test_a_thin_limb_of_a_large_mesh_stays_a_body() -> None:
    """Merged on a grid in one go, it would become a few faces upon faces, with hardly any volume."""
    ring = trimesh.creation.torus(3, 0.05, major_sections=400, minor_sections=200)
    content = make_preview(ring)
    assert content is not None
    small = read_preview(content).mesh
    assert trimesh.Trimesh(small.vertices, small.faces, process=False).volume > ring.volume / 2


def test_a_flat_mesh_keeps_its_box() -> None:
    plane = Mesh([[0, 0, 5], [4, 0, 5], [4, 3, 5], [0, 3, 5]], [[0, 1, 2], [0, 2, 3]])
    content = make_preview(plane)
    assert content is not None
    np.testing.assert_allclose(read_preview(content).mesh.vertices, plane.vertices)


@pytest.mark.parametrize("cut", [0, 3, 20, 60, -1])
def test_a_damaged_preview_is_refused(cut: int) -> None:
    content = make_preview(trimesh.creation.box())
    assert content is not None
    with pytest.raises(ValueError, match="preview"):
        read_preview(content[:cut])


@pytest.mark.parametrize("vertices", [40, 300, 515, 525])
def test_more_faces_than_any_surface_of_so_few_vertices_has(vertices: int) -> None:
    """At an edge with many faces, there is nothing to collapse."""
    generator = np.random.default_rng(vertices)
    corners = np.argsort(generator.random((4000, vertices)), axis=1)[:, :3]
    mesh = Mesh(generator.random((vertices, 3)), corners.astype(np.int32))
    small = read_preview(make_preview(mesh) or b"").mesh
    assert 500 < len(small.faces) <= 2000
