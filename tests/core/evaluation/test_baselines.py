# SPDX-License-Identifier: MIT
import lapy.shapedna
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shapegoogle_core import Mesh, MeshError, Spectrum, compute_spectrum
from shapegoogle_core.evaluation.baselines import D2_RANGE, d2_distribution, shape_dna


def moved(mesh, scale=1.0, turn=0.7):
    rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    return Mesh(scale * mesh.vertices @ rotation.T + [1, 2, 3], mesh.faces, mesh.name)


def test_shape_dna_of_a_sphere(shapes):
    # λ = l(l + 1), 2l + 1 times, and the area is 4π.
    degrees = np.repeat(np.arange(1, 5), 2 * np.arange(1, 5) + 1)
    dna = shape_dna(compute_spectrum(shapes.sphere(4), 30), 24)
    np.testing.assert_allclose(dna, degrees * (degrees + 1) / np.arange(1, 25), rtol=0.01)


def test_shape_dna_of_a_rectangle(shapes):
    # Free boundary: λ = π² (m²/a² + n²/b²).
    m, n = np.meshgrid(np.arange(9), np.arange(9))
    eigenvalues = np.sort((np.pi**2 * (m**2 / 4 + n**2 / 2)).ravel())[1:13]
    dna = shape_dna(compute_spectrum(shapes.rectangle(2, np.sqrt(2), 60), 20), 12)
    expected = eigenvalues * 2 * np.sqrt(2) / (4 * np.pi * np.arange(1, 13))
    np.testing.assert_allclose(dna, expected, rtol=0.01)


def test_shape_dna_is_that_of_lapy(bumpy):
    spectrum = compute_spectrum(bumpy, 50)
    normalised = spectrum.eigenvalues * spectrum.area
    expected = lapy.shapedna.reweight_ev(normalised[1:]) / (4 * np.pi)
    np.testing.assert_allclose(shape_dna(spectrum, 49), expected)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_shape_dna_forgets_size_and_place(bumpy, scale):
    one, other = (shape_dna(compute_spectrum(mesh, 40), 39) for mesh in (bumpy, moved(bumpy, scale)))
    np.testing.assert_allclose(other, one, rtol=1e-6)


def test_parts_show_in_shape_dna_as_zeros(shapes):
    sphere = shapes.sphere(2)
    three = Mesh(
        np.concatenate([sphere.vertices + 4.0 * part for part in range(3)]),
        np.concatenate([sphere.faces + part * len(sphere.vertices) for part in range(3)]),
    )
    dna = shape_dna(compute_spectrum(three, 30), 20)
    assert (dna[:2] == 0).all()
    assert (dna[2:] > 0).all()


def test_weyl_stands_for_eigenvalues_that_a_coarse_mesh_does_not_have(shapes):
    octahedron = shapes.sphere(0)
    dna = shape_dna(compute_spectrum(octahedron, 100), 49)
    assert dna.shape == (49,)
    np.testing.assert_array_equal(dna[len(octahedron.vertices) - 1 :], 1)


def test_d2_of_a_sphere(shapes):
    # P(chord ≤ d) = d² / 4R², and the mean chord is 4R/3.
    edges = np.minimum(np.linspace(0, D2_RANGE, 31), 1.5)
    histogram = d2_distribution(shapes.sphere(5), 1 << 18, bins=30)
    np.testing.assert_allclose(histogram, np.diff(edges**2) / 1.5**2, atol=2e-3)


def test_d2_of_a_rod(shapes):
    # Two points on a line of length 1: density 2 (1 − d), mean ⅓.
    edges = np.linspace(0, 1, 31)
    histogram = d2_distribution(shapes.rectangle(1, 1e-3, 50), 1 << 18, bins=30)
    np.testing.assert_allclose(histogram, np.diff(2 * edges - edges**2), atol=2e-3)


@settings(deadline=None, max_examples=10)
@given(scale=st.floats(1e-3, 1e3), turn=st.floats(0, 6), seed=st.integers(0, 9))
def test_d2_forgets_size_and_place(bumpy, scale, turn, seed):
    one = d2_distribution(bumpy, 1 << 14, 16, seed)
    other = d2_distribution(moved(bumpy, scale, turn), 1 << 14, 16, seed)
    assert one.sum() == pytest.approx(1)
    # A distance on the edge of two bins may fall to either side by rounding.
    assert np.abs(other - one).sum() < 1e-3


def test_d2_counts_surface_and_not_triangles(shapes):
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


def test_d2_is_seeded(bumpy):
    np.testing.assert_array_equal(d2_distribution(bumpy, 999, seed=3), d2_distribution(bumpy, 999, seed=3))
    assert (d2_distribution(bumpy, 999, seed=3) != d2_distribution(bumpy, 999, seed=4)).any()


def test_what_has_no_surface_is_refused():
    for mesh in (
        Mesh(np.eye(3), name="cloud"),
        Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], name="sliver"),
    ):
        with pytest.raises(MeshError, match=f"'{mesh.name}' has no surface"):
            d2_distribution(mesh)


def test_counts_must_be_positive(bumpy):
    spectrum = Spectrum(np.array([0.0, 1.0]), np.eye(2), np.ones(2))
    with pytest.raises(ValueError, match="at least one eigenvalue"):
        shape_dna(spectrum, 0)
    with pytest.raises(ValueError, match="at least one sample and one bin"):
        d2_distribution(bumpy, samples=0)
