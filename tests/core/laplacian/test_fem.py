# SPDX-License-Identifier: MIT
"""Finite elements: exact integrals, and orders of convergence."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from shapegoogle_core.laplacian import Operator, cotangent, fem1, fem2, fem3
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import compute_spectrum
from tests.core.conftest import Shapes


def order(errors: list[float]) -> float:
    """Of convergence, where each mesh has half the edge length of the one before."""
    return float(np.log2(errors[-2] / errors[-1]))


def flat_values(width: float, height: float, k: int, wave: float, frequencies: range) -> FloatArray:
    values = [(wave * m / width) ** 2 + (wave * n / height) ** 2 for m in frequencies for n in frequencies]
    return np.sort(values)[:k]


def error(values: FloatArray, expected: FloatArray) -> float:
    """Largest relative one, among those that are not 0."""
    assert len(values) == len(expected)
    positive = expected > 0
    np.testing.assert_array_equal(values[~positive], 0)
    return float(np.max(np.abs(values[positive] / expected[positive] - 1)))


@pytest.mark.parametrize(("element", "degree"), [(fem1, 1), (fem2, 2), (fem3, 3)])
def test_elements_integrate_their_polynomials_exactly(
    element: Callable[[Mesh], Operator], degree: int
) -> None:
    """∫ |∇f|² and ∫ f² of a polynomial f on a square, from its values at the nodes."""
    square = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [2, 3, 0]])
    operator = element(square)
    x, y = nodes_of(square, degree)[:, :2].T
    f = x**degree + 2 * y**degree
    slope = 5 * degree**2 / (2 * degree - 1)
    square_mean = 5 / (2 * degree + 1) + 4 / (degree + 1) ** 2
    assert f @ (operator.stiffness @ f) == pytest.approx(slope)
    assert f @ (operator.mass @ f) == pytest.approx(square_mean)


def nodes_of(mesh: Mesh, degree: int) -> FloatArray:
    """Where the degrees of freedom lie: read off operators whose values are known, from the documentation."""
    edges = np.unique(np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    starts, ends = mesh.vertices[edges[:, 0]], mesh.vertices[edges[:, 1]]
    shares = np.arange(1, degree) / degree
    on_edges = starts[:, None] + shares[:, None] * (ends - starts)[:, None]
    inside = mesh.vertices[mesh.faces].mean(axis=1) if degree == 3 else np.empty((0, 3))
    return np.concatenate([mesh.vertices, on_edges.reshape(-1, 3), inside])


def test_linear_elements_have_the_cotangents(shapes: type[Shapes]) -> None:
    mesh = shapes.bumpy(2)
    np.testing.assert_allclose(
        fem1(mesh).stiffness.toarray(), cotangent(mesh).stiffness.toarray(), atol=1e-12
    )


@pytest.mark.parametrize("boundary", ["neumann", "dirichlet"])
@pytest.mark.parametrize(
    ("laplacian", "least"), [("cotangent-voronoi", 1.8), ("fem1", 1.8), ("fem2", 3.8), ("fem3", 5.8)]
)
def test_order_on_a_flat_rectangle(laplacian: str, least: float, boundary: str, shapes: type[Shapes]) -> None:
    first = 1 if boundary == "dirichlet" else 0
    expected = flat_values(1.7, 1.0, 10, np.pi, range(first, 9))
    errors = [
        error(
            compute_spectrum(shapes.rectangle(1.7, 1.0, cells), 10, laplacian, boundary).eigenvalues, expected
        )
        for cells in (16, 32)
    ]
    assert order(errors) > least


@pytest.mark.parametrize(("laplacian", "least"), [("fem2", 3.8), ("fem3", 5.8)])
def test_order_on_a_flat_torus(laplacian: str, least: float, shapes: type[Shapes]) -> None:
    expected = flat_values(2.0, 1.2, 13, 2 * np.pi, range(-4, 5))
    errors = [
        error(compute_spectrum(shapes.flat_torus(2.0, 1.2, cells), 13, laplacian).eigenvalues, expected)
        for cells in (10, 20)
    ]
    assert order(errors) > least


@pytest.mark.parametrize("laplacian", ["fem2", "fem3"])
def test_on_a_sphere_flat_triangles_leave_the_second_order(laplacian: str, shapes: type[Shapes]) -> None:
    expected = np.repeat(np.arange(5) * np.arange(1, 6), 2 * np.arange(5) + 1).astype(float)
    coarse, fine = (compute_spectrum(shapes.sphere(s), 25, laplacian).eigenvalues for s in (2, 3))
    assert 1.9 < order([error(coarse, expected), error(fine, expected)]) < 2.3
    linear = compute_spectrum(shapes.sphere(3), 25, "fem1").eigenvalues
    assert error(fine, expected) < error(linear, expected) / 5
    # Of the polyhedron itself both are almost exact: quadratic and cubic elements agree.
    other = {"fem2": "fem3", "fem3": "fem2"}[laplacian]
    np.testing.assert_allclose(fine, compute_spectrum(shapes.sphere(3), 25, other).eigenvalues, rtol=3e-4)


@pytest.mark.parametrize("laplacian", ["fem2", "fem3"])
def test_vertices_have_eigenfunctions_that_are_nearly_orthonormal_there(laplacian: str, bumpy: Mesh) -> None:
    spectrum = compute_spectrum(bumpy, 20, laplacian)
    assert spectrum.eigenvectors.shape == (len(bumpy.vertices), 20)
    products = spectrum.eigenvectors.T @ (spectrum.mass[:, None] * spectrum.eigenvectors)
    np.testing.assert_allclose(products, np.eye(20), atol=0.05)
    linear = compute_spectrum(bumpy, 20, "fem1")
    np.testing.assert_allclose(spectrum.eigenvectors, linear.eigenvectors, atol=0.1)


def test_higher_elements_have_more_pairs_than_vertices() -> None:
    tetrahedron = Mesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    )
    for laplacian, count in (("fem1", 4), ("fem2", 4 + 6), ("fem3", 4 + 2 * 6 + 4)):
        spectrum = compute_spectrum(tetrahedron, 100, laplacian)
        assert spectrum.eigenvectors.shape == (4, count)
        assert (np.diff(spectrum.eigenvalues) >= 0).all()
