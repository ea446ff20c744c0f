# SPDX-License-Identifier: MIT
"""Spectra against analytic ones and against LaPy, and the promises of `Spectrum`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from lapy import Solver, TriaMesh
from threadpoolctl import threadpool_info, threadpool_limits

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import BOUNDARIES, LAPLACIANS, build_operator
from shapegoogle_core.mesh import Mesh, read_mesh
from shapegoogle_core.spectral import compute_spectrum, eigensolver
from shapegoogle_core.spectral import spectrum as spectrum_module
from tests.core.conftest import Shapes

ON_FACES = sorted(set(LAPLACIANS) - {"point-cloud"})
# What needs only as many degrees of freedom as there are vertices.
OPERATORS = sorted(set(ON_FACES) - {"fem2", "fem3"})


def sphere_eigenvalues(k: int) -> np.ndarray:
    """l(l + 1), each 2l + 1 times."""
    return np.concatenate([np.full(2 * degree + 1, degree * (degree + 1.0)) for degree in range(k)])[:k]


def flat_eigenvalues(width: float, height: float, k: int, wave: float, frequencies: range) -> np.ndarray:
    values = [(wave * m / width) ** 2 + (wave * n / height) ** 2 for m in frequencies for n in frequencies]
    return np.sort(values)[:k]


def relative_error(values: np.ndarray, expected: np.ndarray) -> float:
    return float(np.max(np.abs(values - expected)[1:] / expected[1:]))


@pytest.mark.parametrize("laplacian", OPERATORS)
def test_sphere_converges_with_its_multiplicities(laplacian: str, shapes: type[Shapes]) -> None:
    k = 25
    expected = sphere_eigenvalues(k)
    meshes = [shapes.sphere(subdivisions) for subdivisions in (2, 3, 4)]
    errors = [relative_error(compute_spectrum(mesh, k, laplacian).eigenvalues, expected) for mesh in meshes]
    assert errors[-1] < 0.01
    # Second order: halving the edges divides the error by about 4.
    assert errors[0] / errors[1] > 3
    assert errors[1] / errors[2] > 3


@pytest.mark.parametrize("laplacian", OPERATORS)
def test_flat_torus_converges(laplacian: str, shapes: type[Shapes]) -> None:
    k = 13
    expected = flat_eigenvalues(2.0, 1.2, k, 2 * np.pi, range(-4, 5))
    errors = [
        relative_error(
            compute_spectrum(shapes.flat_torus(2.0, 1.2, cells), k, laplacian).eigenvalues, expected
        )
        for cells in (20, 40, 80)
    ]
    assert errors[-1] < 0.01
    assert errors[0] / errors[1] > 3
    assert errors[1] / errors[2] > 3


@pytest.mark.parametrize("laplacian", OPERATORS)
def test_open_rectangle_has_natural_boundary_conditions(laplacian: str, shapes: type[Shapes]) -> None:
    k = 12
    expected = flat_eigenvalues(1.7, 1.0, k, np.pi, range(8))
    errors = [
        relative_error(
            compute_spectrum(shapes.rectangle(1.7, 1.0, cells), k, laplacian).eigenvalues, expected
        )
        for cells in (17, 34, 68)
    ]
    assert errors[-1] < 0.005
    assert errors[0] / errors[1] > 3
    assert errors[1] / errors[2] > 3


@pytest.mark.parametrize("laplacian", OPERATORS)
def test_pairs_are_sorted_orthonormal_and_of_fixed_sign(laplacian: str, bumpy: Mesh) -> None:
    spectrum = compute_spectrum(bumpy, 40, laplacian)
    operator = build_operator(bumpy, laplacian)
    vectors = spectrum.eigenvectors
    assert (np.diff(spectrum.eigenvalues) >= 0).all()
    assert (spectrum.eigenvalues >= 0).all()
    np.testing.assert_allclose(vectors.T @ (operator.mass @ vectors), np.eye(40), atol=1e-9)
    residual = operator.stiffness @ vectors - (operator.mass @ vectors) * spectrum.eigenvalues
    assert np.abs(residual).max() < 1e-9 * abs(operator.stiffness).max() * np.abs(vectors).max()
    largest = np.abs(vectors).argmax(axis=0)
    assert (vectors[largest, np.arange(40)] > 0).all()
    np.testing.assert_allclose(spectrum.mass.sum(), bumpy.area, rtol=1e-9)


def lapy_eigenvalues(mesh: Mesh, k: int, lump: bool) -> np.ndarray:
    solver = Solver(TriaMesh(np.array(mesh.vertices), np.array(mesh.faces)), lump=lump, use_cholmod=False)
    return np.asarray(solver.eigs(k)[0])


@pytest.mark.parametrize(("laplacian", "lump"), [("cotangent", True), ("fem1", False)])
def test_agrees_with_lapy(laplacian: str, lump: bool, bumpy: Mesh) -> None:
    expected = lapy_eigenvalues(bumpy, 30, lump)
    values = compute_spectrum(bumpy, 30, laplacian).eigenvalues
    # LaPy stores single precision.
    np.testing.assert_allclose(values[1:], expected[1:], rtol=1e-4)


@pytest.mark.real_data
@pytest.mark.parametrize("name", ["tosca/cat0.ply", "tosca/gorilla5.ply", "tosca_remeshed/8_gorilla_01.ply"])
def test_agrees_with_lapy_on_real_meshes(name: str, data_folder: Path) -> None:
    mesh = read_mesh(data_folder / name)
    for laplacian, lump in (("fem1", False), ("cotangent", True)):
        expected = lapy_eigenvalues(mesh, 50, lump)
        values = compute_spectrum(mesh, 50, laplacian).eigenvalues
        np.testing.assert_allclose(values, expected, rtol=1e-3, atol=1e-6 * expected[-1])
    # The intrinsic Delaunay triangulation is another discretisation: close, not equal.
    robust = compute_spectrum(mesh, 50).eigenvalues
    np.testing.assert_allclose(robust, values, rtol=0.12, atol=1e-6 * values[-1])


def test_components_have_a_zero_each_and_the_union_of_their_spectra(shapes: type[Shapes]) -> None:
    bumpy, sphere = shapes.bumpy(3), shapes.sphere(2)
    n = len(bumpy.vertices)
    both = Mesh(
        np.concatenate([bumpy.vertices, sphere.vertices + 5]), np.concatenate([bumpy.faces, sphere.faces + n])
    )
    spectrum = compute_spectrum(both, 40)
    apart = np.sort(np.concatenate([compute_spectrum(part, 40).eigenvalues for part in (bumpy, sphere)]))[:40]
    np.testing.assert_allclose(spectrum.eigenvalues, apart, atol=1e-9)
    assert (spectrum.eigenvalues < 1e-9).sum() == 2
    supports = np.abs(spectrum.eigenvectors) > 0
    assert (supports[:n].any(axis=0) ^ supports[n:].any(axis=0)).all()


def test_one_large_component_of_few_vertices_beside_a_small_one_of_many(shapes: type[Shapes]) -> None:
    """Weyl's law promises the coarse component more pairs than it has vertices; the other makes up for it."""
    box, ball = trimesh.creation.box((10, 10, 10)), shapes.sphere(3)
    both = Mesh(
        np.concatenate([box.vertices, ball.vertices + 20]), np.concatenate([box.faces, ball.faces + 8])
    )
    spectrum = compute_spectrum(both, 100)
    assert len(spectrum.eigenvalues) == 100
    assert (np.abs(spectrum.eigenvectors[:8]) > 0).any(axis=0).sum() == 8


def test_more_components_than_eigenpairs() -> None:
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    vertices = np.concatenate([triangle * (1 + i) + 10 * i for i in range(30)])
    spectrum = compute_spectrum(Mesh(vertices, np.arange(90).reshape(30, 3)), 12)
    np.testing.assert_allclose(spectrum.eigenvalues, 0, atol=1e-12)
    np.testing.assert_allclose(
        spectrum.eigenvectors.T @ (spectrum.mass[:, None] * spectrum.eigenvectors), np.eye(12), atol=1e-9
    )


def test_of_too_many_components_the_largest_are_kept(shapes: type[Shapes]) -> None:
    """Which parts get heat must not hang on rounding: a rotation changes nothing."""
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    sizes = np.random.default_rng(0).permutation(30) + 1
    vertices = np.concatenate([triangle * size + 50 * index for index, size in enumerate(sizes)])
    rotation, _ = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))
    faces = np.arange(90).reshape(30, 3)
    for points in (vertices, vertices @ rotation):
        spectrum = compute_spectrum(Mesh(points, faces), 12)
        assert (spectrum.eigenvalues == 0).all()
        heated = (spectrum.eigenvectors != 0).any(axis=1)[::3]
        np.testing.assert_array_equal(heated, sizes > 18)


@pytest.mark.parametrize(("mesh", "k"), [("sphere", 200), ("torus", 120)])
def test_iterative_solver_agrees_with_the_dense_one(
    mesh: str, k: int, shapes: type[Shapes], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Multiple eigenvalues are where a Krylov method could miss some."""
    surface = shapes.sphere(3) if mesh == "sphere" else shapes.flat_torus(2.0, 1.2, 30)
    iterative = compute_spectrum(surface, k)
    monkeypatch.setattr("shapegoogle_core.spectral.spectrum.DENSE_SIZE", len(surface.vertices))
    dense = compute_spectrum(surface, k)
    np.testing.assert_allclose(iterative.eigenvalues, dense.eigenvalues, atol=1e-9 * dense.eigenvalues[-1])


@settings(max_examples=10, deadline=None)
@given(exponent=st.floats(-6, 6), laplacian=st.sampled_from(OPERATORS), seed=st.integers(0, 1000))
def test_eigenvalues_scale_with_the_inverse_area(exponent: float, laplacian: str, seed: int) -> None:
    mesh = trimesh.creation.icosphere(2)
    vertices = mesh.vertices * np.random.default_rng(seed).uniform(0.8, 1.2, (len(mesh.vertices), 1))
    scale = 10.0**exponent
    small = compute_spectrum(Mesh(vertices, mesh.faces), 20, laplacian).eigenvalues
    large = compute_spectrum(Mesh(vertices * scale, mesh.faces), 20, laplacian).eigenvalues
    np.testing.assert_allclose(large[1:] * scale**2, small[1:], rtol=1e-6)


def test_asks_for_no_more_pairs_than_vertices() -> None:
    box = trimesh.creation.box()
    spectrum = compute_spectrum(Mesh(box.vertices, box.faces), 100)
    assert spectrum.eigenvalues.shape == (8,)
    assert spectrum.eigenvectors.shape == (8, 8)


def test_refuses_what_has_no_operator(bumpy: Mesh) -> None:
    with pytest.raises(ValueError, match="laplacian must be one of"):
        compute_spectrum(bumpy, 10, "graph")
    with pytest.raises(ValueError, match="at least 1"):
        compute_spectrum(bumpy, 0)
    with pytest.raises(MeshError, match="'cloud' has no faces"):
        compute_spectrum(Mesh(bumpy.vertices, name="cloud"))
    loose = Mesh(np.concatenate([bumpy.vertices, [[9, 9, 9]]]), bumpy.faces, name="loose")
    with pytest.raises(MeshError, match="'loose' has 1 vertex that no face uses"):
        compute_spectrum(loose)


@pytest.mark.parametrize("laplacian", OPERATORS)
def test_long_strip(laplacian: str, shapes: type[Shapes]) -> None:
    spectrum = compute_spectrum(shapes.rectangle(100.0, 1.0, 600), 20, laplacian)
    expected = (np.pi * np.arange(20) / 100) ** 2
    np.testing.assert_allclose(spectrum.eigenvalues[1:], expected[1:], rtol=0.01)


@pytest.mark.parametrize("boundary", BOUNDARIES)
def test_blas_has_one_thread_meanwhile_and_its_own_number_afterwards(
    boundary: str, monkeypatch: pytest.MonkeyPatch, shapes: type[Shapes]
) -> None:
    def blas_threads() -> set[int]:
        # Of what spectra are computed with; others, such as faiss, bring a BLAS of their own when loaded.
        return {
            library["num_threads"]
            for library in threadpool_info()
            if library["user_api"] == "blas"
            and any(name in library["filepath"] for name in ("numpy", "scipy"))
        }

    seen: list[set[int]] = []
    solve = eigensolver.smallest_pairs

    def watched(*arguments: Any, **options: Any) -> Any:
        seen.append(blas_threads())
        return solve(*arguments, **options)

    monkeypatch.setattr(spectrum_module, "smallest_pairs", watched)
    with threadpool_limits(2, user_api="blas"):
        compute_spectrum(shapes.rectangle(2.0, 1.0, 30), 10, "cotangent", boundary)
        assert blas_threads() == {2}
    assert seen == [{1}]
