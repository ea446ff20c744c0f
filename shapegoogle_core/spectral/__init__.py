# SPDX-License-Identifier: MIT
"""Spectrum of the Laplace–Beltrami operator, and its heat kernel (paper, sections 3.1 and 3.3)."""

from shapegoogle_core.spectral.heat_kernel import checked_shape, heat_kernel, heat_kernel_diagonal
from shapegoogle_core.spectral.spectrum import Spectrum, check_spectrum, compute_spectrum, operator_spectrum

__all__ = [
    "Spectrum",
    "check_spectrum",
    "checked_shape",
    "compute_spectrum",
    "heat_kernel",
    "heat_kernel_diagonal",
    "operator_spectrum",
]
