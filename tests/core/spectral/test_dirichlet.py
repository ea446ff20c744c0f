# SPDX-License-Identifier: MIT
"""Spectra of functions that are held at 0 on open boundaries."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.spatial import Delaunay
from scipy.special import jn_zeros

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import LAPLACIANS, Operator
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.spectral import compute_spectrum, operator_spectrum
from tests.core.conftest import Shapes

ON_FACES = sorted(set(LAPLACIANS) - {"point-cloud"})


@pytest.mark.parametrize("laplacian", ["robust", "cotangent", "fem1", "fem2", "fem3"])
def test_drum(laplacian: str) -> None:
    """A round membrane that is held at its rim: squares of the zeros of Bessel functions."""
    expected = np.sort([zero**2 for m in range(9) for zero in jn_zeros(m, 5) for _ in range(2 if m else 1)])
    values = compute_spectrum(disc(24), 12, laplacian, "dirichlet").eigenvalues
    np.testing.assert_allclose(values, expected[:12], rtol=0.03 if laplacian == "fem1" else 0.02)
    assert values[0] == pytest.approx(5.7832, rel=0.01)


def disc(rings: int) -> Mesh:
    radii = np.repeat(np.arange(rings + 1), np.maximum(6 * np.arange(rings + 1), 1))
    angles = np.concatenate([np.arange(max(6 * r, 1)) / max(6 * r, 1) for r in range(rings + 1)]) * 2 * np.pi
    points = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1) / rings
    return Mesh(np.column_stack([points, np.zeros(len(points))]), Delaunay(points).simplices)


@pytest.mark.parametrize("laplacian", ON_FACES)
def test_dirichlet_holds_the_boundary_and_only_that(laplacian: str, shapes: type[Shapes]) -> None:
    spectrum = compute_spectrum(shapes.rectangle(1.0, 1.0, 12), 20, laplacian, "dirichlet")
    x, y, _ = shapes.rectangle(1.0, 1.0, 12).vertices.T
    rim = (np.minimum(x, 1 - x) < 1e-9) | (np.minimum(y, 1 - y) < 1e-9)
    assert (spectrum.eigenvectors[rim] == 0).all()
    assert (spectrum.eigenvectors[~rim] != 0).any(axis=1).all()
    assert spectrum.eigenvalues[0] > 18  # 2π² = 19.7
    assert spectrum.mass.sum() == pytest.approx(1)


def test_closed_surfaces_have_no_boundary_to_hold(bumpy: Mesh) -> None:
    free, held = (compute_spectrum(bumpy, 20, "robust", boundary) for boundary in ("neumann", "dirichlet"))
    np.testing.assert_array_equal(free.eigenvalues, held.eigenvalues)
    np.testing.assert_array_equal(free.eigenvectors, held.eigenvectors)


@pytest.mark.parametrize("k", [2, 3, 30])
def test_a_closed_part_beside_an_open_one(k: int, shapes: type[Shapes]) -> None:
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


def test_what_dirichlet_cannot_do(shapes: type[Shapes]) -> None:
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
