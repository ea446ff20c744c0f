# SPDX-License-Identifier: MIT
"""Baselines: known shapes, invariances, and refusals."""

from __future__ import annotations

from collections.abc import Callable

import lapy.shapedna
import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.variants.baselines import (
    D2_RANGE,
    d2_distribution,
    diffusion_distances,
    gps_distances,
    shape_dna,
    surface_moments,
)
from shapegoogle_core import Mesh, MeshError, Spectrum, compute_spectrum, heat_kernel
from shapegoogle_core.mesh.mesh import FloatArray
from tests.core.conftest import Shapes


def moved(mesh: Mesh, scale: float = 1.0, turn: float = 0.7) -> Mesh:
    rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    return Mesh(scale * mesh.vertices @ rotation.T + [1, 2, 3], mesh.faces, mesh.name)


def test_shape_dna_of_a_sphere(shapes: type[Shapes]) -> None:
    # λ = l(l + 1), 2l + 1 times, and the area is 4π.
    degrees = np.repeat(np.arange(1, 5), 2 * np.arange(1, 5) + 1)
    dna = shape_dna(compute_spectrum(shapes.sphere(4), 30), 24)
    np.testing.assert_allclose(dna, degrees * (degrees + 1) / np.arange(1, 25), rtol=0.01)


def test_shape_dna_of_a_rectangle(shapes: type[Shapes]) -> None:
    # Free boundary: λ = π² (m²/a² + n²/b²).
    m, n = np.meshgrid(np.arange(9), np.arange(9))
    eigenvalues = np.sort((np.pi**2 * (m**2 / 4 + n**2 / 2)).ravel())[1:13]
    dna = shape_dna(compute_spectrum(shapes.rectangle(2, np.sqrt(2), 60), 20), 12)
    expected = eigenvalues * 2 * np.sqrt(2) / (4 * np.pi * np.arange(1, 13))
    np.testing.assert_allclose(dna, expected, rtol=0.01)


def test_shape_dna_is_that_of_lapy(bumpy: Mesh) -> None:
    spectrum = compute_spectrum(bumpy, 50)
    normalised = spectrum.eigenvalues * spectrum.area
    expected = lapy.shapedna.reweight_ev(normalised[1:]) / (4 * np.pi)
    np.testing.assert_allclose(shape_dna(spectrum, 49), expected)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_shape_dna_forgets_size_and_place(bumpy: Mesh, scale: float) -> None:
    one, other = (shape_dna(compute_spectrum(mesh, 40), 39) for mesh in (bumpy, moved(bumpy, scale)))
    np.testing.assert_allclose(other, one, rtol=1e-6)


def test_parts_show_in_shape_dna_as_zeros(shapes: type[Shapes]) -> None:
    sphere = shapes.sphere(2)
    three = Mesh(
        np.concatenate([sphere.vertices + 4.0 * part for part in range(3)]),
        np.concatenate([sphere.faces + part * len(sphere.vertices) for part in range(3)]),
    )
    dna = shape_dna(compute_spectrum(three, 30), 20)
    assert (dna[:2] == 0).all()
    assert (dna[2:] > 0).all()


def test_weyl_stands_for_eigenvalues_that_a_coarse_mesh_does_not_have(shapes: type[Shapes]) -> None:
    octahedron = shapes.sphere(0)
    dna = shape_dna(compute_spectrum(octahedron, 100), 49)
    assert dna.shape == (49,)
    np.testing.assert_array_equal(dna[len(octahedron.vertices) - 1 :], 1)


def test_d2_of_a_sphere(shapes: type[Shapes]) -> None:
    # P(chord ≤ d) = d² / 4R², and the mean chord is 4R/3.
    edges = np.minimum(np.linspace(0, D2_RANGE, 31), 1.5)
    histogram = d2_distribution(shapes.sphere(5), 1 << 18, bins=30)
    np.testing.assert_allclose(histogram, np.diff(edges**2) / 1.5**2, atol=2e-3)


def test_d2_of_a_rod(shapes: type[Shapes]) -> None:
    # Two points on a line of length 1: density 2 (1 − d), mean ⅓.
    edges = np.linspace(0, 1, 31)
    histogram = d2_distribution(shapes.rectangle(1, 1e-3, 50), 1 << 18, bins=30)
    np.testing.assert_allclose(histogram, np.diff(2 * edges - edges**2), atol=2e-3)


@settings(deadline=None, max_examples=10)
@given(scale=st.floats(1e-3, 1e3), turn=st.floats(0, 6), seed=st.integers(0, 9))
def test_d2_forgets_size_and_place(bumpy: Mesh, scale: float, turn: float, seed: int) -> None:
    one = d2_distribution(bumpy, 1 << 14, 16, seed)
    other = d2_distribution(moved(bumpy, scale, turn), 1 << 14, 16, seed)
    assert one.sum() == pytest.approx(1)
    # A distance on the edge of two bins may fall to either side by rounding.
    assert np.abs(other - one).sum() < 1e-3


def test_d2_counts_surface_and_not_triangles(shapes: type[Shapes]) -> None:
    coarse = shapes.rectangle(2, 1, 4)
    # The left half meshed finely, the right half as it was.
    fine = shapes.rectangle(1, 1, 40)
    right = shapes.rectangle(1, 1, 2)
    uneven = Mesh(
        np.concatenate([fine.vertices, right.vertices + np.eye(3)[0]]),
        np.concatenate([fine.faces, right.faces + len(fine.vertices)]),
    )
    difference = np.abs(d2_distribution(coarse, 1 << 16, 32) - d2_distribution(uneven, 1 << 16, 32))
    assert difference.sum() < 0.03


def test_d2_is_seeded(bumpy: Mesh) -> None:
    np.testing.assert_array_equal(d2_distribution(bumpy, 999, seed=3), d2_distribution(bumpy, 999, seed=3))
    assert (d2_distribution(bumpy, 999, seed=3) != d2_distribution(bumpy, 999, seed=4)).any()


def test_what_has_no_surface_is_refused() -> None:
    for mesh in (
        Mesh(np.eye(3), name="cloud"),
        Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], name="sliver"),
    ):
        with pytest.raises(MeshError, match=f"'{mesh.name}' has no surface"):
            d2_distribution(mesh)


def test_counts_must_be_positive(bumpy: Mesh) -> None:
    spectrum = Spectrum(np.array([0.0, 1.0]), np.eye(2), np.ones(2))
    with pytest.raises(ValueError, match="at least one eigenvalue"):
        shape_dna(spectrum, 0)
    with pytest.raises(ValueError, match="at least one sample and one bin"):
        d2_distribution(bumpy, samples=0)


def all_pairs(distances: FloatArray, weights: FloatArray, bins: int = 16) -> FloatArray:
    """Histogram of all distances between vertices, each pair counting with both areas."""
    pairs = np.outer(weights, weights) / weights.sum() ** 2
    relative = np.minimum(distances / (distances * pairs).sum(), D2_RANGE)
    return np.asarray(np.histogram(relative, bins, (0.0, D2_RANGE), weights=pairs)[0])


def test_diffusion_distances_come_from_the_heat_kernel(bumpy: Mesh) -> None:
    # d_t(x, y)² = K_2t(x, x) + K_2t(y, y) - 2 K_2t(x, y)
    spectrum, time = compute_spectrum(bumpy, 60), 0.01
    kernel = np.array(
        [heat_kernel(spectrum, x, 2 * time * spectrum.area) for x in range(len(bumpy.vertices))]
    )
    heat = np.diag(kernel)
    distances = np.sqrt(np.maximum(heat[:, None] + heat - 2 * kernel, 0))
    histogram = diffusion_distances(spectrum, time, 1 << 17, bins=16)
    assert histogram.sum() == pytest.approx(1)
    assert np.abs(histogram - all_pairs(distances, spectrum.mass)).sum() < 0.02


def test_gps_distances_come_from_the_greens_function(bumpy: Mesh) -> None:
    # G(x, y) = Σ φ(x) φ(y) / λ: the squared distance is G(x, x) + G(y, y) - 2 G(x, y).
    spectrum = compute_spectrum(bumpy, 26)
    vectors = spectrum.eigenvectors[:, 1:]
    green = vectors @ np.diag(1 / spectrum.eigenvalues[1:]) @ vectors.T
    diagonal = np.diag(green)
    distances = np.sqrt(np.maximum(diagonal[:, None] + diagonal - 2 * green, 0))
    histogram = gps_distances(spectrum, 25, 1 << 17, bins=16)
    assert np.abs(histogram - all_pairs(distances, spectrum.mass)).sum() < 0.02


@pytest.mark.parametrize("describe", [diffusion_distances, gps_distances])
def test_spectral_distances_forget_size_place_and_signs(
    bumpy: Mesh, describe: Callable[..., FloatArray]
) -> None:
    spectra = [compute_spectrum(mesh, 40) for mesh in (bumpy, moved(bumpy, 50.0))]
    turned = Spectrum(spectra[1].eigenvalues, -spectra[1].eigenvectors, spectra[1].mass)
    one, other = (describe(spectrum, samples=1 << 14) for spectrum in (spectra[0], turned))
    assert np.abs(other - one).sum() < 1e-3


def test_a_soup_has_no_distances_but_a_histogram() -> None:
    soup = Spectrum(np.zeros(3), np.eye(3), np.ones(3))
    assert gps_distances(soup, samples=99)[0] == 1
    assert diffusion_distances(soup, samples=99).sum() == pytest.approx(1)


def test_moments_of_a_sphere(shapes: type[Shapes]) -> None:
    # Over the unit sphere the means of x², x⁴, x²y² are 1/3, 1/5, 1/15; the axes are any.
    moments = surface_moments(shapes.sphere(5), 4)
    exponents = [(p, q, n - p - q) for n in (2, 3, 4) for p in range(n, -1, -1) for q in range(n - p, -1, -1)]
    assert len(moments) == len(exponents)
    means = {(2, 0, 0): 1 / 3, (4, 0, 0): 1 / 5, (2, 2, 0): 1 / 15}
    for exponent, moment in zip(exponents, moments, strict=True):
        order = sum(exponent)
        a, b, c = sorted(exponent, reverse=True)
        expected = means.get((a, b, c), 0.0)
        assert moment**order == pytest.approx(expected, abs=2e-3)


def test_moments_are_the_means_of_many_points(bumpy: Mesh) -> None:
    tilted = moved(Mesh(bumpy.vertices * [3, 2, 1], bumpy.faces))
    surface = trimesh.Trimesh(tilted.vertices, tilted.faces, process=False)
    points = trimesh.sample.sample_surface(surface, 1 << 20, seed=0)[0]
    points -= points.mean(axis=0)
    _, _, axes = np.linalg.svd(points, full_matrices=False)
    x, y, z = (points @ axes.T / np.sqrt((points**2).sum(axis=1).mean())).T
    moments = surface_moments(tilted, 3)
    # Of order 3: xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz
    cubes = [x**3, x**2 * y, x**2 * z, x * y**2, x * y * z, x * z**2, y**3, y**2 * z, y * z**2, z**3]
    np.testing.assert_allclose(moments[6:] ** 3, [abs(cube.mean()) for cube in cubes], atol=5e-3)
    np.testing.assert_allclose(moments[[0, 3, 5]] ** 2, [(axis**2).mean() for axis in (x, y, z)], atol=5e-3)
    np.testing.assert_allclose(moments[[1, 2, 4]] ** 2, 0, atol=1e-12)


@settings(deadline=None, max_examples=10)
@given(scale=st.floats(1e-3, 1e3), turn=st.floats(0, 6))
def test_moments_forget_size_place_and_mirror(bumpy: Mesh, scale: float, turn: float) -> None:
    long = Mesh(bumpy.vertices * [3, 2, 1], bumpy.faces)
    mirrored = Mesh(moved(long, scale, turn).vertices * [1, 1, -1], long.faces)
    # Roots make rounding of zeros large.
    np.testing.assert_allclose(surface_moments(mirrored) ** 7, surface_moments(long) ** 7, atol=1e-6)


def test_moments_do_not_depend_on_triangles(bumpy: Mesh) -> None:
    long = Mesh(bumpy.vertices * [3, 2, 1], bumpy.faces)
    fine = trimesh.Trimesh(long.vertices, long.faces, process=False).subdivide()
    again = Mesh(fine.vertices, fine.faces)
    np.testing.assert_allclose(surface_moments(again) ** 7, surface_moments(long) ** 7, atol=1e-6)


def test_baselines_refuse_parameters_out_of_range(bumpy: Mesh) -> None:
    spectrum = Spectrum(np.array([0.0, 1.0]), np.eye(2), np.ones(2))
    calls: tuple[tuple[Callable[[], FloatArray], str], ...] = (
        (lambda: diffusion_distances(spectrum, 0.0), "time must be a positive"),
        (lambda: diffusion_distances(spectrum, bins=0), "one sample and one bin"),
        (lambda: gps_distances(spectrum, samples=0), "one sample and one bin"),
        (lambda: gps_distances(spectrum, 0), "count must be a whole number of at least 1"),
        (lambda: surface_moments(bumpy, 1), "order 2 at least"),
    )
    for call, message in calls:
        with pytest.raises(ValueError, match=message):
            call()
    with pytest.raises(MeshError, match="'cloud' has no surface"):
        surface_moments(Mesh(np.eye(3), name="cloud"))
