# SPDX-License-Identifier: MIT
"""Spectrum of the Laplace–Beltrami operator, and its heat kernel (paper, sections 3.1 and 3.3)."""

from shapegoogle_core.spectral.heat_kernel import heat_kernel, heat_kernel_diagonal
from shapegoogle_core.spectral.spectrum import Spectrum, compute_spectrum, operator_spectrum

__all__ = ["Spectrum", "compute_spectrum", "heat_kernel", "heat_kernel_diagonal", "operator_spectrum"]
