# SPDX-License-Identifier: MIT
"""What all operators have in common, finite elements of higher order, boundary conditions."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import jn_zeros

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import LAPLACIANS, Operator, build_operator, cotangent, fem1, fem2, fem3
from shapegoogle_core.laplacian.cotangent import voronoi_areas
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.measures import vertex_areas
from shapegoogle_core.spectral import compute_spectrum, operator_spectrum

ON_FACES = sorted(set(LAPLACIANS) - {"point-cloud"})


def order(errors: list[float]) -> float:
    """Of convergence, where each mesh has half the edge length of the one before."""
    return float(np.log2(errors[-2] / errors[-1]))


def flat_values(width: float, height: float, k: int, wave: float, frequencies: range) -> np.ndarray:
    values = [(wave * m / width) ** 2 + (wave * n / height) ** 2 for m in frequencies for n in frequencies]
    return np.sort(values)[:k]


def error(values: np.ndarray, expected: np.ndarray) -> float:
    """Largest relative one, among those that are not 0."""
    assert len(values) == len(expected)
    positive = expected > 0
    np.testing.assert_array_equal(values[~positive], 0)
    return float(np.max(np.abs(values[positive] / expected[positive] - 1)))


@pytest.mark.parametrize("laplacian", sorted(LAPLACIANS))
def test_is_symmetric_and_semidefinite_and_its_masses_sum_to_the_area(laplacian, shapes):
    mesh = shapes.bumpy(2)
    operator = build_operator(mesh, laplacian)
    for matrix in (operator.stiffness, operator.mass):
        np.testing.assert_allclose((matrix - matrix.T).toarray(), 0, atol=1e-12)
    np.testing.assert_allclose(operator.stiffness.sum(axis=1), 0, atol=1e-10)
    assert np.linalg.eigvalsh(operator.stiffness.toarray())[0] > -1e-9
    assert np.linalg.eigvalsh(operator.mass.toarray())[0] > 0
    # Points without faces stand on a surface that only nearly is this one.
    accuracy = 0.01 if laplacian == "point-cloud" else 1e-9
    assert operator.mass.sum() == pytest.approx(mesh.area, rel=accuracy)
    assert operator.lumped_mass.shape == (len(mesh.vertices),)
    assert operator.lumped_mass.sum() == pytest.approx(mesh.area, rel=accuracy)


@pytest.mark.parametrize(("element", "degree"), [(fem1, 1), (fem2, 2), (fem3, 3)])
def test_elements_integrate_their_polynomials_exactly(element, degree):
    """∫ |∇f|² and ∫ f² of a polynomial f on a square, from its values at the nodes."""
    square = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [2, 3, 0]])
    operator = element(square)
    x, y = nodes_of(square, degree)[:, :2].T
    f = x**degree + 2 * y**degree
    slope = 5 * degree**2 / (2 * degree - 1)
    square_mean = 5 / (2 * degree + 1) + 4 / (degree + 1) ** 2
    assert f @ (operator.stiffness @ f) == pytest.approx(slope)
    assert f @ (operator.mass @ f) == pytest.approx(square_mean)


def nodes_of(mesh: Mesh, degree: int) -> np.ndarray:
    """Where the degrees of freedom lie: read off operators whose values are known, from the documentation."""
    edges = np.unique(np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    starts, ends = mesh.vertices[edges[:, 0]], mesh.vertices[edges[:, 1]]
    shares = np.arange(1, degree) / degree
    on_edges = starts[:, None] + shares[:, None] * (ends - starts)[:, None]
    inside = mesh.vertices[mesh.faces].mean(axis=1) if degree == 3 else np.empty((0, 3))
    return np.concatenate([mesh.vertices, on_edges.reshape(-1, 3), inside])


def test_linear_elements_have_the_cotangents(shapes):
    mesh = shapes.bumpy(2)
    np.testing.assert_allclose(
        fem1(mesh).stiffness.toarray(), cotangent(mesh).stiffness.toarray(), atol=1e-12
    )


@pytest.mark.parametrize("boundary", ["neumann", "dirichlet"])
@pytest.mark.parametrize(
    ("laplacian", "least"), [("cotangent-voronoi", 1.8), ("fem1", 1.8), ("fem2", 3.8), ("fem3", 5.8)]
)
def test_order_on_a_flat_rectangle(laplacian, least, boundary, shapes):
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
def test_order_on_a_flat_torus(laplacian, least, shapes):
    expected = flat_values(2.0, 1.2, 13, 2 * np.pi, range(-4, 5))
    errors = [
        error(compute_spectrum(shapes.flat_torus(2.0, 1.2, cells), 13, laplacian).eigenvalues, expected)
        for cells in (10, 20)
    ]
    assert order(errors) > least


@pytest.mark.parametrize("laplacian", ["fem2", "fem3"])
def test_on_a_sphere_flat_triangles_leave_the_second_order(laplacian, shapes):
    expected = np.repeat(np.arange(5) * np.arange(1, 6), 2 * np.arange(5) + 1).astype(float)
    coarse, fine = (compute_spectrum(shapes.sphere(s), 25, laplacian).eigenvalues for s in (2, 3))
    assert 1.9 < order([error(coarse, expected), error(fine, expected)]) < 2.3
    linear = compute_spectrum(shapes.sphere(3), 25, "fem1").eigenvalues
    assert error(fine, expected) < error(linear, expected) / 5
    # Of the polyhedron itself both are almost exact: quadratic and cubic elements agree.
    other = {"fem2": "fem3", "fem3": "fem2"}[laplacian]
    np.testing.assert_allclose(fine, compute_spectrum(shapes.sphere(3), 25, other).eigenvalues, rtol=3e-4)


@pytest.mark.parametrize("laplacian", ["robust", "cotangent", "fem1", "fem2", "fem3"])
def test_drum(laplacian):
    """A round membrane that is held at its rim: squares of the zeros of Bessel functions."""
    expected = np.sort([zero**2 for m in range(9) for zero in jn_zeros(m, 5) for _ in range(2 if m else 1)])
    values = compute_spectrum(disc(24), 12, laplacian, "dirichlet").eigenvalues
    np.testing.assert_allclose(values, expected[:12], rtol=0.03 if laplacian == "fem1" else 0.02)
    assert values[0] == pytest.approx(5.7832, rel=0.01)


def disc(rings: int) -> Mesh:
    from scipy.spatial import Delaunay

    radii = np.repeat(np.arange(rings + 1), np.maximum(6 * np.arange(rings + 1), 1))
    angles = np.concatenate([np.arange(max(6 * r, 1)) / max(6 * r, 1) for r in range(rings + 1)]) * 2 * np.pi
    points = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1) / rings
    return Mesh(np.column_stack([points, np.zeros(len(points))]), Delaunay(points).simplices)


@pytest.mark.parametrize("laplacian", ON_FACES)
def test_dirichlet_holds_the_boundary_and_only_that(laplacian, shapes):
    spectrum = compute_spectrum(shapes.rectangle(1.0, 1.0, 12), 20, laplacian, "dirichlet")
    x, y, _ = shapes.rectangle(1.0, 1.0, 12).vertices.T
    rim = (np.minimum(x, 1 - x) < 1e-9) | (np.minimum(y, 1 - y) < 1e-9)
    assert (spectrum.eigenvectors[rim] == 0).all()
    assert (spectrum.eigenvectors[~rim] != 0).any(axis=1).all()
    assert spectrum.eigenvalues[0] > 18  # 2π² = 19.7
    assert spectrum.mass.sum() == pytest.approx(1)


def test_closed_surfaces_have_no_boundary_to_hold(bumpy):
    free, held = (compute_spectrum(bumpy, 20, "robust", boundary) for boundary in ("neumann", "dirichlet"))
    np.testing.assert_array_equal(free.eigenvalues, held.eigenvalues)
    np.testing.assert_array_equal(free.eigenvectors, held.eigenvectors)


@pytest.mark.parametrize("k", [2, 3, 30])
def test_a_closed_part_beside_an_open_one(k, shapes):
    """Only the closed one has a constant."""
    ball, sheet = shapes.sphere(2), shapes.rectangle(1.0, 1.0, 12)
    both = Mesh(
        np.concatenate([ball.vertices, sheet.vertices + 5]),
        np.concatenate([ball.faces, sheet.faces + len(ball.vertices)]),
    )
    together = compute_spectrum(both, k, "cotangent", "dirichlet").eigenvalues
    apart = [compute_spectrum(part, 30, "cotangent", "dirichlet").eigenvalues for part in (ball, sheet)]
    np.testing.assert_allclose(together, np.sort(np.concatenate(apart))[:k], rtol=1e-9, atol=1e-12)
    assert np.count_nonzero(together == 0) == 1


def test_what_dirichlet_cannot_do(shapes):
    triangle = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]], name="quad")
    with pytest.raises(MeshError, match="'quad': all its vertices lie on open edges"):
        compute_spectrum(triangle, 3, "cotangent", "dirichlet")
    assert (
        compute_spectrum(triangle, 3, "fem2", "dirichlet").eigenvalues[0] > 0
    )  # the diagonal's middle is free
    with pytest.raises(MeshError, match="'sphere': the boundary of points without faces is not known"):
        compute_spectrum(shapes.sphere(2), 3, "point-cloud", "dirichlet")
    with pytest.raises(ValueError, match="boundary must be one of neumann, dirichlet, not 'robin'"):
        compute_spectrum(shapes.sphere(2), 3, boundary="robin")
    identity = sparse.csc_array(sparse.eye_array(3))
    with pytest.raises(ValueError, match="boundary of this operator is not known"):
        operator_spectrum(Operator(identity, identity), 2, "dirichlet")
    with pytest.raises(ValueError, match="none is left"):
        operator_spectrum(Operator(identity, identity, boundary=np.arange(3)), 2, "dirichlet")


@pytest.mark.parametrize("laplacian", ["fem2", "fem3"])
def test_vertices_have_eigenfunctions_that_are_nearly_orthonormal_there(laplacian, bumpy):
    spectrum = compute_spectrum(bumpy, 20, laplacian)
    assert spectrum.eigenvectors.shape == (len(bumpy.vertices), 20)
    products = spectrum.eigenvectors.T @ (spectrum.mass[:, None] * spectrum.eigenvectors)
    np.testing.assert_allclose(products, np.eye(20), atol=0.05)
    linear = compute_spectrum(bumpy, 20, "fem1")
    np.testing.assert_allclose(spectrum.eigenvectors, linear.eigenvectors, atol=0.1)


def test_higher_elements_have_more_pairs_than_vertices():
    tetrahedron = Mesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    )
    for laplacian, count in (("fem1", 4), ("fem2", 4 + 6), ("fem3", 4 + 2 * 6 + 4)):
        spectrum = compute_spectrum(tetrahedron, 100, laplacian)
        assert spectrum.eigenvectors.shape == (4, count)
        assert (np.diff(spectrum.eigenvalues) >= 0).all()


def test_voronoi_areas_of_a_right_grid_an_equilateral_and_an_obtuse_triangle(shapes):
    grid = shapes.rectangle(1.0, 1.0, 8)
    x, y, _ = grid.vertices.T
    inner = (np.minimum(x, 1 - x) > 1e-9) & (np.minimum(y, 1 - y) > 1e-9)
    np.testing.assert_allclose(voronoi_areas(grid)[inner], 1 / 64)
    equilateral = Mesh([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0]], [[0, 1, 2]])
    np.testing.assert_allclose(voronoi_areas(equilateral), vertex_areas(equilateral))
    acute = Mesh([[0, 0, 0], [4, 0, 0], [1, 3, 0]], [[0, 1, 2]])
    # The circumcentre is (2, 1): quadrilaterals from a corner over the middles of its sides.
    np.testing.assert_allclose(voronoi_areas(acute), [2.0, 2.25 - 0.25, 2.0], atol=0.5)
    obtuse = Mesh([[0, 0, 0], [4, 0, 0], [2, 0.5, 0]], [[0, 1, 2]])
    np.testing.assert_allclose(voronoi_areas(obtuse), [0.25, 0.25, 0.5])


def test_voronoi_area_is_what_is_nearest_to_a_vertex():
    """Against counting random points of an acute triangle."""
    corners = np.array([[0, 0, 0], [4, 0, 0], [1, 3, 0.0]])
    random = np.random.default_rng(0)
    weights = random.dirichlet(np.ones(3), 200_000)
    nearest = np.linalg.norm((weights @ corners)[:, None] - corners, axis=2).argmin(axis=1)
    expected = np.bincount(nearest) / len(nearest) * 6
    np.testing.assert_allclose(voronoi_areas(Mesh(corners, [[0, 1, 2]])), expected, atol=0.02)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10_000), flatness=st.floats(-9, 0))
def test_voronoi_areas_are_positive_and_sum_to_the_area(seed, flatness):
    points = np.random.default_rng(seed).standard_normal((12, 3)) * [1, 1, 10.0**flatness]
    mesh = Mesh(points, np.arange(12).reshape(4, 3))
    areas = voronoi_areas(mesh)
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(mesh.area)


def test_points_of_a_sphere_have_its_spectrum(shapes):
    random = np.random.default_rng(0).standard_normal((4000, 3))
    cloud = Mesh(random / np.linalg.norm(random, axis=1, keepdims=True))
    expected = np.repeat(np.arange(5) * np.arange(1, 6), 2 * np.arange(5) + 1).astype(float)
    spectrum = compute_spectrum(cloud, 25, "point-cloud")
    # Random points, which leave gaps and crowds, are 5 % low; evenly spread ones 1 to 2 %.
    np.testing.assert_allclose(spectrum.eigenvalues, expected, rtol=0.07, atol=1e-9)
    even = Mesh(shapes.sphere(4).vertices)
    np.testing.assert_allclose(
        compute_spectrum(even, 25, "point-cloud").eigenvalues, expected, rtol=0.01, atol=1e-9
    )
    assert spectrum.area == pytest.approx(4 * np.pi, rel=0.02)
    with pytest.raises(MeshError, match="'few' has only 3 points"):
        compute_spectrum(Mesh(np.eye(3), name="few"), 2, "point-cloud")
