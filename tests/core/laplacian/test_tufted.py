# SPDX-License-Identifier: MIT
"""The Laplacian of points without faces."""

from __future__ import annotations

import numpy as np
import pytest

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.spectral import compute_spectrum
from tests.core.conftest import Shapes


def test_points_of_a_sphere_have_its_spectrum(shapes: type[Shapes]) -> None:
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
