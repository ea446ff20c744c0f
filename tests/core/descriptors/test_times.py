# SPDX-License-Identifier: MIT
"""Default times: their range, their spacing, and that they follow the size of a shape."""

from __future__ import annotations

import math

import numpy as np
import pytest

from shapegoogle_core.descriptors import default_exponents, default_times, time_at, time_range
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.spectral import Spectrum, compute_spectrum


def spectrum_of(*eigenvalues: float) -> Spectrum:
    count = len(eigenvalues)
    return Spectrum(np.array(eigenvalues), np.eye(count), np.ones(count))


def test_weights_are_one_in_ten_thousand_at_both_ends() -> None:
    spectrum = spectrum_of(0.0, 2.0, 30.0)
    shortest, longest = time_range(spectrum)
    assert math.exp(-30 * shortest) == pytest.approx(1e-4)
    assert math.exp(-2 * longest) == pytest.approx(1e-4)


def test_zeros_of_loose_parts_do_not_count() -> None:
    assert time_range(spectrum_of(0.0, 0.0, 1e-12, 2.0, 30.0)) == time_range(spectrum_of(0.0, 2.0, 30.0))


def test_refuses_a_spectrum_of_zeros() -> None:
    for function in (time_range, default_times):
        with pytest.raises(MeshError, match=r"all 3 eigenvalues of the spectrum are 0.*compute more"):
            function(spectrum_of(0.0, 0.0, 0.0))


def test_times_are_evenly_spaced_on_a_logarithmic_scale() -> None:
    spectrum = spectrum_of(0.0, 2.0, 30.0)
    times = default_times(spectrum, 7)
    assert (times[0], times[-1]) == pytest.approx(time_range(spectrum))
    np.testing.assert_allclose(np.diff(np.log(times)), np.log(times[1] / times[0]))
    assert times[3] == time_at(spectrum, 0.5)
    with pytest.raises(ValueError, match="at least 1, not 0"):
        default_times(spectrum, 0)


def test_times_scale_with_the_area(bumpy: Mesh) -> None:
    small, large = (
        default_times(compute_spectrum(Mesh(scale * bumpy.vertices, bumpy.faces), 20)) for scale in (1, 7)
    )
    np.testing.assert_allclose(large, 49 * small, rtol=1e-6)


def test_exponents_follow_the_area_and_not_the_base() -> None:
    exponents = default_exponents(1.0)
    assert (exponents[0], exponents[-1], len(exponents)) == (-13.0, 0.0, 105)
    np.testing.assert_allclose(default_exponents(16.0), exponents + 4)
    np.testing.assert_allclose(3.0 ** default_exponents(5.0, 3.0), 2.0 ** default_exponents(5.0))
