# SPDX-License-Identifier: MIT
"""Heat kernels from resolvents against full decompositions and closed forms, and what heat must obey."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.creatures import make_creature
from shapegoogle_core.descriptors import heat_kernel_signature
from shapegoogle_core.laplacian import Operator, build_operator
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.preprocessing import repair
from shapegoogle_core.spectral import Spectrum, operator_spectrum
from shapegoogle_core.spectral.rational import _ladder, rational_diagonal, rational_kernel
from tests.core.conftest import Shapes

pytest.importorskip("skimage", reason="creatures need the optional extra 'demo'")

Decompose = Callable[[str, str], tuple[Operator, Spectrum]]
OPERATORS = ("cotangent", "fem1", "robust")


def joined(*meshes: Mesh) -> Mesh:
    """Several meshes as the components of one."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces), "parts")


@pytest.fixture(scope="module")
def examples(shapes: type[Shapes], bumpy: Mesh) -> dict[str, Mesh]:
    triangle = Mesh(np.array([[0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0]]), np.array([[0, 1, 2]]))
    return {
        "sphere": shapes.sphere(3),
        "bumpy": bumpy,
        "creature": repair(make_creature("octopus", 100, 900).rest),
        "open": shapes.rectangle(3.0, 1.0, 45),
        "parts": joined(shapes.bumpy(2, 1), shapes.rectangle(1.0, 0.5, 12), triangle),
    }


@pytest.fixture(scope="module")
def decomposed(examples: dict[str, Mesh]) -> Decompose:
    """Operator of an example and all of its eigenpairs."""

    @cache
    def decompose(name: str, laplacian: str) -> tuple[Operator, Spectrum]:
        operator = build_operator(examples[name], laplacian)
        values, vectors = scipy.linalg.eigh(operator.stiffness.toarray(), operator.mass.toarray())
        return operator, Spectrum(np.maximum(values, 0), vectors, operator.lumped_mass)

    return decompose


def all_times(spectrum: Spectrum) -> np.ndarray:
    """From far below the squared edges to where 50 eigenpairs are enough."""
    reach = 12 / spectrum.eigenvalues[50]
    return np.geomspace(1e-3 * spectrum.area / len(spectrum.mass), reach, 13)


# Every operator on one shape, and the default one on every shape.
CASES = [*(("bumpy", laplacian) for laplacian in OPERATORS), ("creature", "robust"), ("parts", "robust")]


@pytest.mark.parametrize(("name", "laplacian"), [*CASES, ("sphere", "robust"), ("open", "robust")])
def test_signature_is_that_of_the_full_decomposition(
    name: str, laplacian: str, decomposed: Decompose
) -> None:
    operator, full = decomposed(name, laplacian)
    times = all_times(full)
    values = rational_diagonal(operator, times)
    np.testing.assert_allclose(values, heat_kernel_signature(full, times), rtol=2e-4)


@pytest.mark.parametrize(("name", "laplacian"), CASES)
def test_kernel_is_that_of_the_full_decomposition(name: str, laplacian: str, decomposed: Decompose) -> None:
    operator, full = decomposed(name, laplacian)
    for time in all_times(full)[::4]:
        expected = (full.eigenvectors * np.exp(-time * full.eigenvalues)) @ full.eigenvectors.T
        scale = np.sqrt(np.diag(expected))
        for source in (0, len(scale) // 2, len(scale) - 1):
            heat = rational_kernel(operator, source, time)
            assert (np.abs(heat - expected[source]) <= 2e-4 * scale * scale[source]).all()
            warm = expected[source] > 0.03 * scale * scale[source]
            np.testing.assert_allclose(heat[warm], expected[source, warm], rtol=0.01)
            assert heat @ operator.lumped_mass == pytest.approx(1, abs=1e-6)


def test_heat_stays_in_its_component(examples: dict[str, Mesh]) -> None:
    operator = build_operator(examples["parts"])
    first = slice(0, len(operator.lumped_mass) - 3)
    heat = rational_kernel(operator, len(operator.lumped_mass) - 1, 1e-3)
    assert (heat[first] == 0).all()
    np.testing.assert_allclose(heat[-3:], 1 / operator.lumped_mass[-3:].sum(), rtol=1e-6)


def test_signature_is_exact_long_after_a_small_component_is_even(examples: dict[str, Mesh]) -> None:
    operator = build_operator(examples["parts"])
    latest = 9.9 * operator.lumped_mass.sum()
    values = rational_diagonal(operator, latest)
    np.testing.assert_allclose(values[-3:, 0], 1 / operator.lumped_mass[-3:].sum(), rtol=1e-7)


@pytest.mark.parametrize("laplacian", OPERATORS)
def test_plane_away_from_everything(laplacian: str, shapes: type[Shapes]) -> None:
    torus = shapes.flat_torus(2.0, 1.2, 80)
    times = np.array([0.01, 0.02, 0.03])  # 15 to 45 times the area of a vertex; the torus closes at 0.1
    values = rational_diagonal(build_operator(torus, laplacian), times)
    np.testing.assert_allclose(values, np.tile(1 / (4 * np.pi * times), (len(values), 1)), rtol=0.01)


def test_sphere_is_the_legendre_series(shapes: type[Shapes]) -> None:
    times = np.array([0.1, 0.2, 1.0])
    degrees = np.arange(60)
    expected = [((2 * degrees + 1) * np.exp(-degrees * (degrees + 1) * t)).sum() / (4 * np.pi) for t in times]
    values = rational_diagonal(build_operator(shapes.sphere(4)), times)
    np.testing.assert_allclose(values, np.tile(expected, (len(values), 1)), rtol=0.01)


@pytest.mark.parametrize("laplacian", OPERATORS)
def test_semigroup(laplacian: str, bumpy: Mesh) -> None:
    operator = build_operator(bumpy, laplacian)
    edge = bumpy.area / len(bumpy.vertices)
    for time in (0.1 * edge, edge, 30 * edge):
        later = rational_diagonal(operator, 2 * time)[:, 0]
        for source in (5, 300):
            heat = rational_kernel(operator, source, time)
            assert heat @ (operator.mass @ heat) == pytest.approx(later[source], rel=3e-4)
            # Of a consistent mass the discrete kernel itself, not this sum for it, is negative in places.
            assert laplacian == "fem1" or heat.min() > -2e-4 * heat.max()


def test_before_anything_flows_heat_is_where_it_was_put(bumpy: Mesh) -> None:
    operator = build_operator(bumpy, "cotangent")
    values = rational_diagonal(operator, 1e-9 * bumpy.area)
    np.testing.assert_allclose(values[:, 0], 1 / operator.lumped_mass, rtol=1e-3)


def test_scales_with_the_mesh(bumpy: Mesh) -> None:
    times = np.array([1e-3, 0.1]) * bumpy.area
    large = Mesh(1000 * bumpy.vertices, bumpy.faces)
    expected = rational_diagonal(build_operator(bumpy), times)
    values = rational_diagonal(build_operator(large), 1e6 * times)
    np.testing.assert_allclose(1e6 * values, expected, rtol=1e-4)


def test_takes_a_spectrum_where_that_reaches(decomposed: Decompose) -> None:
    operator, full = decomposed("creature", "robust")
    spectrum = operator_spectrum(operator, 100)
    times = np.geomspace(1, 30, 12) / spectrum.eigenvalues[-1]
    expected = heat_kernel_signature(full, times)
    truncated = heat_kernel_signature(spectrum, times)
    values = rational_diagonal(operator, times, spectrum=spectrum, tolerance=1e-3)
    np.testing.assert_allclose(values, expected, rtol=1e-3)
    reached = (values == truncated).all(axis=0)
    error = np.abs(truncated / expected - 1).max(axis=0)
    assert error[0] > 0.3  # what the truncated spectrum makes of a small time
    assert reached[-2:].all()
    assert not reached[:4].any()
    assert (error[reached] < 1e-3).all()
    # Long past the area, where only the spectrum serves.
    late = rational_diagonal(operator, [100 * spectrum.area], spectrum=spectrum)
    np.testing.assert_allclose(late, 1 / spectrum.area, rtol=1e-3)


def test_a_spectrum_without_all_components_reaches_nothing(examples: dict[str, Mesh]) -> None:
    operator = build_operator(examples["parts"])
    times = 0.1 * operator.lumped_mass.sum()
    values = rational_diagonal(operator, times, spectrum=operator_spectrum(operator, 2))
    np.testing.assert_array_equal(values, rational_diagonal(operator, times))


def test_all_eigenpairs_reach_everything(decomposed: Decompose) -> None:
    operator, full = decomposed("open", "cotangent")
    times = [1e-6, 1.0]
    values = rational_diagonal(operator, times, spectrum=full)
    np.testing.assert_array_equal(values, heat_kernel_signature(full, times))


@given(exponents=st.lists(st.floats(-15, 15), min_size=1, max_size=6))
@settings(max_examples=40, deadline=None)
def test_fractions_fit_the_exponential_at_any_times(exponents: list[float]) -> None:
    times = 10.0 ** np.array(exponents)
    ladder = _ladder(times)
    assert ladder.errors.max() < 1.5e-4
    for column, time in enumerate(times):
        values = np.concatenate([[0], np.geomspace(1e-5, 1e5, 3000)]) / time
        single = ladder.poles / (values[:, None] + ladder.poles)
        pairs = single[:, :-1] * single[:, 1:]
        error = np.abs(pairs @ ladder.weights[:, column] - np.exp(-time * values))
        allowed = ladder.errors[column] * pairs[:, ladder.bounding[column]]
        assert (error <= 1.01 * allowed).all()  # 1 %: the largest error was found on other points
        assert (np.exp(-time * values) <= pairs[:, ladder.above[column]]).all()


def uneven_mesh(shapes: type[Shapes]) -> Mesh:
    """A sphere with a vertex beside another one, ten-thousand times nearer than the next."""
    sphere = shapes.sphere(3)
    a, b, c = sphere.vertices[sphere.faces[0]]
    n = len(sphere.vertices)
    inner = [a + 1e-4 * ((1 - w) * (b - a) + w * (c - a)) for w in (0.3, 0.7)]
    i, j, k = sphere.faces[0]
    faces = [[i, n, n + 1], [i, j, n], [i, n + 1, k], [n, j, n + 1], [n + 1, j, k]]
    return Mesh(np.vstack([sphere.vertices, inner]), np.vstack([sphere.faces[1:], faces]), "uneven")


def test_says_what_can_be_proved_on_uneven_meshes(shapes: type[Shapes]) -> None:
    operator = build_operator(uneven_mesh(shapes), "cotangent")
    spectrum = operator_spectrum(operator, len(operator.lumped_mass))
    times = np.geomspace(1e-6, 1, 12) / len(spectrum.mass)
    with pytest.raises(ValueError, match="cannot be proved") as refused:
        rational_diagonal(operator, times, tolerance=2e-4)
    advice = re.search(r"allow ([\d.e-]+)", str(refused.value))
    assert advice is not None
    allowed = float(advice[1])
    values = rational_diagonal(operator, times, tolerance=allowed)
    np.testing.assert_allclose(values, heat_kernel_signature(spectrum, times), rtol=allowed)


def test_refuses_what_it_cannot_do(bumpy: Mesh, shapes: type[Shapes]) -> None:
    operator = build_operator(bumpy)
    for times in ([], [[1.0]], [0.0], [-1.0], [np.nan], [np.inf]):
        with pytest.raises(ValueError, match="positive numbers"):
            rational_diagonal(operator, times)
    with pytest.raises(ValueError, match="10 times the area"):
        rational_diagonal(operator, 11 * bumpy.area)
    for tolerance in (0, 1, -0.1, np.nan):
        with pytest.raises(ValueError, match="tolerance"):
            rational_diagonal(operator, 0.1, tolerance=tolerance)
        with pytest.raises(ValueError, match="tolerance"):
            rational_kernel(operator, 0, 0.1, tolerance=tolerance)
    for source in (-1, len(bumpy.vertices)):
        with pytest.raises(ValueError, match="source"):
            rational_kernel(operator, source, 0.1)
    with pytest.raises(ValueError, match="time must be a positive number"):
        rational_kernel(operator, 0, 0.0)
    for other in (shapes.sphere(2), shapes.sphere(3)):
        with pytest.raises(ValueError, match="another mesh"):
            rational_diagonal(operator, 0.1, spectrum=operator_spectrum(build_operator(other), 5))


@pytest.mark.parametrize("laplacian", ["fem2", "fem3"])
def test_values_elsewhere_than_at_vertices_are_refused(laplacian: str, shapes: type[Shapes]) -> None:
    operator = build_operator(shapes.sphere(1), laplacian)
    with pytest.raises(ValueError, match="a value for each vertex"):
        rational_kernel(operator, 0, 0.1)
    with pytest.raises(ValueError, match="a value for each vertex"):
        rational_diagonal(operator, [0.1])
