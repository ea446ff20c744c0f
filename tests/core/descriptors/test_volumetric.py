# SPDX-License-Identifier: MIT
"""The volumetric heat kernel signature against a closed form, and where shapes are not closed."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from shapegoogle_core.descriptors import volumetric_hks
from shapegoogle_core.mesh import Mesh
from tests.core.conftest import Shapes


def test_volumetric_hks_of_a_box() -> None:
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


def test_volumetric_hks_changes_little_with_a_rotation(bumpy: Mesh) -> None:
    """The grid shows: on a nearly round shape, whose values differ little, by up to a quarter of that."""
    times = [0.01, 0.04]
    values = volumetric_hks(bumpy, times)
    moved = Mesh(7 * bumpy.vertices @ Rotation.random(rng=2).as_matrix() + 5, bumpy.faces)
    change = np.abs(volumetric_hks(moved, times) - values)
    assert (change.mean(axis=0) < 0.3 * values.std(axis=0)).all()


def test_volumetric_hks_of_sheets_and_of_parts_far_apart(shapes: type[Shapes]) -> None:
    sheet = shapes.rectangle(1.0, 1.0, 10)
    assert np.isfinite(volumetric_hks(sheet, [0.01])).all()
    sphere = shapes.sphere(2)
    vertices = np.concatenate([sphere.vertices, sphere.vertices + 1e4])
    apart = Mesh(vertices, np.concatenate([sphere.faces, sphere.faces + len(sphere.vertices)]))
    assert np.isfinite(volumetric_hks(apart, [0.01])).all()
