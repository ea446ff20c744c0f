# SPDX-License-Identifier: MIT
"""Eigenfunctions of the Laplacian, and heat kernels at small times."""

from shapegoogle_core.spectral.spectrum import Spectrum, compute_spectrum, operator_spectrum

__all__ = ["Spectrum", "compute_spectrum", "operator_spectrum"]
