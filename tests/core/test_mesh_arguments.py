# SPDX-License-Identifier: MIT
"""Public functions take meshes of other libraries, and tuples of arrays, as they take a `Mesh`."""

from __future__ import annotations

import inspect
from collections.abc import Callable

import numpy as np
import pytest
import trimesh
from lapy import TriaMesh

import shapegoogle_core as sg
from shapegoogle_core.mesh import MeshLike
from shapegoogle_core.mesh.mesh import FloatArray

FUNCTIONS: dict[str, Callable[[MeshLike], FloatArray]] = {
    "build_operator": lambda mesh: sg.build_operator(mesh).stiffness.toarray(),
    "compute_spectrum": lambda mesh: sg.compute_spectrum(mesh, 10).eigenvectors,
    "detect_keypoints": lambda mesh: (
        sg.detect_keypoints(mesh, sg.compute_spectrum(mesh, 10), persistence=1e-6).response
    ),
    "geodesic_histograms": sg.geodesic_histograms,
    "heat_kernel": lambda mesh: sg.heat_kernel(mesh, 0, 0.1, method="rational"),
    "heat_kernel_signature": lambda mesh: sg.heat_kernel_signature(mesh, [0.1], method="rational"),
    "mesh_hog": sg.mesh_hog,
    "shape_contexts": sg.shape_contexts,
    "vertex_spin_images": sg.vertex_spin_images,
    "volumetric_hks": lambda mesh: sg.volumetric_hks(mesh, [0.1], resolution=5, eigenpairs=5),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_kind_of_mesh_has_the_same_result(name: str) -> None:
    ball = trimesh.creation.icosphere(1, radius=2.0)
    ball.vertices *= [1.0, 1.2, 1.5]
    vertices, faces = np.array(ball.vertices), np.array(ball.faces)
    expected = FUNCTIONS[name](sg.Mesh(vertices, faces))
    others: list[MeshLike] = [
        (vertices, faces),
        (vertices.tolist(), faces.tolist()),
        ball,
        TriaMesh(vertices, faces),
    ]
    for other in others:
        np.testing.assert_array_equal(FUNCTIONS[name](other), expected)


@pytest.mark.parametrize("name", sg.__all__)
def test_no_public_function_takes_a_mesh_alone(name: str) -> None:
    function = getattr(sg, name)
    if inspect.isfunction(function):
        parameters = inspect.signature(function).parameters.values()
        assert not [parameter.name for parameter in parameters if parameter.annotation == "Mesh"]
