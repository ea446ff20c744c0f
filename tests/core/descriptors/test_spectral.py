# SPDX-License-Identifier: MIT
"""Descriptors against closed forms, and the invariances that they claim."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapegoogle_core.descriptors import (
    default_times,
    global_point_signature,
    heat_kernel_signature,
    log_heat_kernel_signature,
    scale_invariant_hks,
    time_range,
    wave_kernel_signature,
)
from shapegoogle_core.keypoints import detect_keypoints
from shapegoogle_core.laplacian import build_operator
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import Spectrum, compute_spectrum, heat_kernel
from shapegoogle_core.words import spatially_sensitive_bag
from tests.core.conftest import Shapes


@pytest.fixture(scope="module")
def spectrum(bumpy: Mesh) -> Spectrum:
    return compute_spectrum(bumpy, 80)


def test_hks_of_the_sphere_is_the_legendre_series(shapes: type[Shapes]) -> None:
    spectrum = compute_spectrum(shapes.sphere(4), 100)
    times = np.array([0.1, 0.3, 1.0])
    degrees = np.arange(10)
    expected = [((2 * degrees + 1) * np.exp(-degrees * (degrees + 1) * t)).sum() / (4 * np.pi) for t in times]
    values = heat_kernel_signature(spectrum, times)
    np.testing.assert_allclose(values, np.tile(expected, (len(values), 1)), rtol=0.01)


def test_hks_of_the_rectangle_is_the_cosine_series(shapes: type[Shapes]) -> None:
    mesh = shapes.rectangle(1.5, 1.0, 45)
    spectrum = compute_spectrum(mesh, 120)
    t = 0.05
    x, y = mesh.vertices[:, 0] / 1.5, mesh.vertices[:, 1]
    expected = np.ones(len(x))
    for coordinate, length in ((x, 1.5), (y, 1.0)):
        modes = np.arange(1, 40)
        decay = np.exp(-((np.pi * modes / length) ** 2) * t)
        expected *= (1 + 2 * (np.cos(np.pi * np.outer(coordinate, modes)) ** 2 @ decay)) / length
    np.testing.assert_allclose(heat_kernel_signature(spectrum, [t])[:, 0], expected, rtol=0.02)


def test_hks_is_the_diagonal_of_the_heat_kernel(spectrum: Spectrum) -> None:
    for vertex in (0, 17, 200):
        heat = heat_kernel(spectrum, vertex, 0.1)
        np.testing.assert_allclose(heat[vertex], heat_kernel_signature(spectrum, 0.1)[vertex, 0])
        np.testing.assert_allclose(heat @ spectrum.mass, 1.0)  # heat is conserved


def test_hks_tends_to_the_inverse_area(spectrum: Spectrum) -> None:
    late = heat_kernel_signature(spectrum, 1e3 / spectrum.eigenvalues[1])
    np.testing.assert_allclose(late, 1 / spectrum.area, rtol=1e-9)


@settings(max_examples=25, deadline=None)
@given(times=st.lists(st.floats(1e-3, 1e3), min_size=2, max_size=6))
def test_hks_is_positive_and_falls_with_time(times: Any) -> None:
    spectrum = Spectrum(
        np.array([0.0, 1.0, 3.0, 10.0]), np.random.default_rng(0).standard_normal((7, 4)), np.ones(7)
    )
    values = heat_kernel_signature(spectrum, np.sort(times))
    assert (values > 0).all()
    assert (np.diff(values, axis=1) <= 1e-12).all()


def test_hks_options(spectrum: Spectrum) -> None:
    times = np.array([0.05, 0.2, 0.5])
    raw = heat_kernel_signature(spectrum, times)
    np.testing.assert_allclose(heat_kernel_signature(spectrum, times, multiply_by_time=True), raw * times)
    unit = heat_kernel_signature(spectrum, times, multiply_by_time=True, normalize=True)
    np.testing.assert_allclose(np.linalg.norm(unit, axis=1), 1.0)
    np.testing.assert_allclose(unit * np.linalg.norm(raw * times, axis=1, keepdims=True), raw * times)


@pytest.mark.parametrize("times", [[], [-1.0], [0.0], [np.nan], [[1.0, 2.0]]])
def test_times_must_be_positive(spectrum: Spectrum, times: list[Any]) -> None:
    with pytest.raises(ValueError, match="positive numbers"):
        heat_kernel_signature(spectrum, times)


def test_si_hks_is_the_modulus_of_the_fourier_transform(spectrum: Spectrum) -> None:
    tau = np.arange(-8, 4, 0.25)
    log_kernel = np.log(heat_kernel_signature(spectrum, 2.0**tau))
    expected = np.abs(np.fft.fft(np.diff(log_kernel, axis=1), axis=1))[:, :5]
    np.testing.assert_allclose(scale_invariant_hks(spectrum, tau=tau, frequencies=5), expected, atol=1e-9)


def test_si_hks_hardly_changes_with_the_size(bumpy: Mesh) -> None:
    tau = np.arange(-12, 12, 0.125)  # the kernel is flat beyond both ends for either size
    values = [
        scale_invariant_hks(compute_spectrum(Mesh(bumpy.vertices * s, bumpy.faces), 80), tau=tau)
        for s in (1.0, 1.7)
    ]
    raw = [
        heat_kernel_signature(compute_spectrum(Mesh(bumpy.vertices * s, bumpy.faces), 80), 2.0**tau)
        for s in (1.0, 1.7)
    ]
    change = np.linalg.norm(values[1] - values[0]) / np.linalg.norm(values[0])
    raw_change = np.linalg.norm(raw[1] - raw[0]) / np.linalg.norm(raw[0])
    assert change < 0.02
    assert raw_change > 0.5


def test_si_hks_default_follows_the_area(bumpy: Mesh, spectrum: Spectrum) -> None:
    tau = np.log2(spectrum.area) + np.arange(-13, 0 + 1 / 16, 1 / 8)
    explicit = scale_invariant_hks(spectrum, alpha=2, tau=tau, frequencies=6)
    np.testing.assert_array_equal(scale_invariant_hks(spectrum), explicit)
    np.testing.assert_allclose(scale_invariant_hks(spectrum, alpha=3.0), explicit, rtol=1e-9)
    large = compute_spectrum(Mesh(30.0 * bumpy.vertices, bumpy.faces), 80)
    np.testing.assert_allclose(scale_invariant_hks(large), explicit, rtol=1e-4)


def test_hks_default_times_cover_the_spectrum(spectrum: Spectrum) -> None:
    values = heat_kernel_signature(spectrum)
    np.testing.assert_array_equal(values, heat_kernel_signature(spectrum, default_times(spectrum)))
    assert values.shape == (len(spectrum.mass), 100)
    np.testing.assert_allclose(values[:, -1], 1 / spectrum.area, rtol=0.01)


def test_rational_hks_is_that_of_all_eigenpairs(bumpy: Mesh) -> None:
    full = compute_spectrum(bumpy, len(bumpy.vertices))
    times = np.array([1e-3, 0.05]) * bumpy.area
    expected = heat_kernel_signature(full, times, multiply_by_time=True, normalize=True)
    for shape in (bumpy, build_operator(bumpy)):
        values = heat_kernel_signature(shape, times, method="rational", multiply_by_time=True, normalize=True)
        np.testing.assert_allclose(values, expected, rtol=1e-3)


def test_rational_hks_takes_default_times_from_a_spectrum(bumpy: Mesh, spectrum: Spectrum) -> None:
    values = heat_kernel_signature(bumpy, method="rational", spectrum=spectrum)
    late = heat_kernel_signature(spectrum)[:, 50:]
    np.testing.assert_array_equal(values[:, 50:], late)
    with pytest.raises(ValueError, match="pass times or spectrum"):
        heat_kernel_signature(bumpy, method="rational")


@pytest.mark.parametrize(
    "options",
    [
        {"alpha": 1.0},
        {"tau": [1.0, 2.0]},
        {"tau": [1.0, 2.0, 4.0]},
        {"frequencies": 0},
        {"tau": [1.0, 2.0, 3.0], "frequencies": 3},
    ],
)
def test_si_hks_refuses_bad_parameters(spectrum: Spectrum, options: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"alpha|tau|frequencies"):
        scale_invariant_hks(spectrum, **options)


def test_wks_is_a_weighted_mean_of_squared_eigenfunctions(spectrum: Spectrum) -> None:
    energies = np.log(spectrum.eigenvalues[[5, 20, 60]])
    values = wave_kernel_signature(spectrum, energies, sigma=0.3)
    squares = spectrum.eigenvectors[:, 1:] ** 2
    assert (values <= squares.max(axis=1, keepdims=True) + 1e-12).all()
    for column, energy in enumerate(energies):
        weights = np.exp(-((energy - np.log(spectrum.eigenvalues[1:])) ** 2) / (2 * 0.3**2))
        np.testing.assert_allclose(values[:, column], squares @ weights / weights.sum())
    np.testing.assert_allclose(values.T @ spectrum.mass, 1.0, rtol=1e-6)


def test_wks_narrow_energies_pick_single_eigenfunctions(spectrum: Spectrum) -> None:
    values = wave_kernel_signature(spectrum, [np.log(spectrum.eigenvalues[7])], sigma=1e-4)
    np.testing.assert_allclose(values[:, 0], spectrum.eigenvectors[:, 7] ** 2)


def test_wks_needs_positive_eigenvalues() -> None:
    flat = Spectrum(np.array([0.0, 0.0, 1.0]), np.eye(3), np.ones(3))
    with pytest.raises(ValueError, match="two positive eigenvalues"):
        wave_kernel_signature(flat)
    with pytest.raises(ValueError, match="explicit sigma"):
        wave_kernel_signature(Spectrum(np.array([0.0, 1.0, 2.0]), np.eye(3), np.ones(3)), [0.1])


def test_wks_default_grid(spectrum: Spectrum) -> None:
    logarithms = np.log(spectrum.eigenvalues[[1, -1]])
    step = np.ptp(logarithms) / (49 + 28)  # 2σ = 14 steps stay free at both ends
    energies = logarithms[0] + 14 * step + step * np.arange(50)
    explicit = wave_kernel_signature(spectrum, energies, sigma=7 * step)
    for count in (50, np.int64(50)):
        np.testing.assert_allclose(wave_kernel_signature(spectrum, count), explicit)
    for options in ({"energies": 0}, {"energies": energies, "sigma": 0.0}):
        with pytest.raises(ValueError, match=r"at least 1|positive"):
            wave_kernel_signature(spectrum, **options)


@pytest.mark.parametrize("seed", [0, 1])
def test_descriptors_follow_the_vertices(bumpy: Mesh, seed: int) -> None:
    """Rigid motion and another order of the vertices permute the values, and change nothing else."""
    random = np.random.default_rng(seed)
    rotation, _ = np.linalg.qr(random.standard_normal((3, 3)))
    order = random.permutation(len(bumpy.vertices))
    rank = np.argsort(order)
    moved = Mesh((bumpy.vertices @ rotation + random.standard_normal(3))[order], rank[bumpy.faces])
    original, changed = compute_spectrum(bumpy, 60), compute_spectrum(moved, 60)
    signatures: list[Callable[[Spectrum], FloatArray]] = [
        lambda spectrum: heat_kernel_signature(spectrum, [0.05, 0.5]),
        lambda spectrum: scale_invariant_hks(spectrum, tau=np.arange(-6, 2, 0.25)),
        lambda spectrum: wave_kernel_signature(spectrum, 20),
    ]
    for describe in signatures:
        np.testing.assert_allclose(describe(changed), describe(original)[order], rtol=1e-5)


def test_the_logarithm_of_the_signature_ends_where_there_is_no_heat() -> None:
    spectrum = Spectrum(np.array([0.0, 2.0]), np.array([[1.0, 1.0], [0.0, 0.0]]), np.ones(2))
    values = log_heat_kernel_signature(spectrum, [0.5, 1.0])
    plain = heat_kernel_signature(spectrum, [0.5, 1.0], multiply_by_time=True)
    np.testing.assert_allclose(values[0], np.log(plain[0]))
    np.testing.assert_allclose(values[1], -10)


def test_gps_of_the_flat_torus(shapes: type[Shapes]) -> None:
    """Over an eigenspace of m functions the squares sum to m / (A λ) everywhere: the torus looks alike."""
    spectrum = compute_spectrum(shapes.flat_torus(2.0, 1.2, 40), 20, "cotangent")
    values = global_point_signature(spectrum, 4)  # λ = (2π/2)² twice, then (2π/1.2)² twice
    for columns, length in (([0, 1], 2.0), ([2, 3], 1.2)):
        expected = 2 / (2.4 * (2 * np.pi / length) ** 2)
        np.testing.assert_allclose((values[:, columns] ** 2).sum(axis=1), expected, rtol=0.02)


def test_gps_has_no_unit_and_fades_beyond_the_spectrum(bumpy: Mesh) -> None:
    spectra = [compute_spectrum(Mesh(scale * bumpy.vertices, bumpy.faces), 12) for scale in (1.0, 30.0)]
    one, other = (np.abs(global_point_signature(spectrum, 15)) for spectrum in spectra)
    np.testing.assert_allclose(other, one, atol=1e-6)
    assert (one[:, :11] > 0).any(axis=0).all()
    assert (one[:, 11:] == 0).all()
    with pytest.raises(ValueError, match="count must be a whole number of at least 1"):
        global_point_signature(spectra[0], 0)


@pytest.mark.parametrize(
    "describe",
    [
        default_times,
        global_point_signature,
        scale_invariant_hks,
        time_range,
        wave_kernel_signature,
        lambda shape: detect_keypoints(shape, shape),
        lambda shape: spatially_sensitive_bag(np.ones((642, 2)), shape, 1.0),
    ],
)
def test_a_mesh_is_not_a_spectrum(describe: Callable[..., object], bumpy: Mesh) -> None:
    with pytest.raises(ValueError, match=r"a Spectrum is needed, not Mesh; pass compute_spectrum\(mesh\)"):
        describe(bumpy)


def test_the_kind_of_shape_is_checked_before_the_times(bumpy: Mesh) -> None:
    with pytest.raises(ValueError, match="'spectral' needs a Spectrum, not Mesh"):
        heat_kernel_signature(bumpy)
    with pytest.raises(ValueError, match="without a spectrum there are no default times"):
        heat_kernel_signature(bumpy, method="rational")
