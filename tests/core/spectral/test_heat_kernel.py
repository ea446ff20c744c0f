# SPDX-License-Identifier: MIT
"""The two methods of the heat kernel: what they take, and that they agree."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import build_operator
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.spectral import compute_spectrum, heat_kernel, heat_kernel_diagonal


def test_both_methods_agree_where_the_spectrum_is_complete(bumpy: Mesh) -> None:
    full = compute_spectrum(bumpy, len(bumpy.vertices))
    time = 0.01 * bumpy.area
    expected = heat_kernel(full, 7, time)
    for shape in (bumpy, build_operator(bumpy)):
        heat = heat_kernel(shape, 7, time, method="rational")
        np.testing.assert_allclose(heat, expected, atol=1e-3 * expected[7])
        diagonal = heat_kernel_diagonal(shape, time, method="rational")
        np.testing.assert_allclose(diagonal, heat_kernel_diagonal(full, time), rtol=1e-3)


def test_the_source_is_a_vertex(bumpy: Mesh) -> None:
    spectrum = compute_spectrum(bumpy, 10)
    for source in (-1, 642):
        with pytest.raises(ValueError, match=f"source must be a vertex from 0 to 641, not {source}"):
            heat_kernel(spectrum, source, 0.1)
        with pytest.raises(ValueError, match=f"source must be a vertex from 0 to 641, not {source}"):
            heat_kernel(bumpy, source, 0.1, method="rational")


def test_each_method_needs_its_kind_of_shape(bumpy: Mesh) -> None:
    spectrum = compute_spectrum(bumpy, 10)
    with pytest.raises(ValueError, match=r"'spectral' needs a Spectrum, not Mesh; call compute_spectrum\(\)"):
        heat_kernel(bumpy, 0, 0.1)
    with pytest.raises(ValueError, match="'spectral' needs a Spectrum, not Operator"):
        heat_kernel_diagonal(build_operator(bumpy), 0.1)
    with pytest.raises(ValueError, match="'rational' needs a mesh or an operator, not a Spectrum"):
        heat_kernel(spectrum, 0, 0.1, method="rational")
    with pytest.raises(ValueError, match="method must be one of spectral, rational, not 'exact'"):
        heat_kernel(spectrum, 0, 0.1, method="exact")


def test_times_are_positive_numbers(bumpy: Mesh) -> None:
    spectrum = compute_spectrum(bumpy, 10)
    for shape, method in ((spectrum, "spectral"), (bumpy, "rational")):
        wrong: list[Any] = [[], "abc", [0.0], [[1.0]], [np.nan], None]
        for times in wrong:
            with pytest.raises(ValueError, match="times must be a list of positive numbers"):
                heat_kernel_diagonal(shape, times, method=method)
        for time in (0, -1.0, np.inf, [1.0, 2.0], "a"):
            with pytest.raises(ValueError, match="time must be a positive number, not"):
                heat_kernel(shape, 0, time, method=method)  # type: ignore[arg-type]
        with pytest.raises(ValueError, match=r"source must be a vertex from 0 to 641, not 1\.5"):
            heat_kernel(shape, 1.5, 0.1, method=method)  # type: ignore[arg-type]


def test_negative_eigenvalues_are_refused(bumpy: Mesh) -> None:
    operator = build_operator(bumpy, "cotangent")
    with pytest.raises(MeshError, match="negative eigenvalues; use another Laplacian"):
        heat_kernel_diagonal(replace(operator, stiffness=-operator.stiffness), [0.1], method="rational")
