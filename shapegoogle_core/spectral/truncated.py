# SPDX-License-Identifier: MIT
"""Heat kernels as sums over the eigenpairs of a truncated spectrum (paper, section 3.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral.spectrum import Spectrum

__all__ = ["checked_times", "truncated_diagonal", "truncated_kernel"]


def checked_times(times: ArrayLike) -> FloatArray:
    """Convert times to an array and check that they are positive.

    Parameters
    ----------
    times : (d,) array_like or float
        Times in squared mesh units.

    Returns
    -------
    times : (d,) array

    Raises
    ------
    ValueError
        If there are more axes than one, or a time is not positive and finite.
    """
    array = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if array.ndim != 1 or not (np.isfinite(array).all() and (array > 0).all()):
        raise ValueError("times must be a list of positive numbers, in squared mesh units")
    return array


def truncated_kernel(spectrum: Spectrum, source: int, time: float) -> FloatArray:
    """Sum K_t(x, y) = Σ_l exp(-λ_l t) φ_l(x) φ_l(y) over the eigenpairs of a spectrum (paper, equation 5).

    Parameters
    ----------
    spectrum : Spectrum
        Eigenpairs.
    source : int
        Vertex x.
    time : float
        t > 0, in squared mesh units.

    Returns
    -------
    heat : (n,) array
        K_t(x, y) for all y, in 1 / squared mesh units.

    Raises
    ------
    ValueError
        If the source is not a vertex, or the time is not positive and finite.
    """
    n = len(spectrum.mass)
    if not 0 <= source < n:
        raise ValueError(f"source must be a vertex from 0 to {n - 1}, not {source}")
    decay = np.exp(-spectrum.eigenvalues * checked_times(time))
    return np.asarray(spectrum.eigenvectors @ (decay * spectrum.eigenvectors[source]))


def truncated_diagonal(spectrum: Spectrum, times: ArrayLike) -> FloatArray:
    """Sum K_t(x, x) = Σ_l exp(-λ_l t) φ_l(x)² over the eigenpairs of a spectrum (paper, equation 6).

    Parameters
    ----------
    spectrum : Spectrum
        Eigenpairs.
    times : (d,) array_like
        Times t > 0, in squared mesh units.

    Returns
    -------
    values : (n, d) array
        In 1 / squared mesh units.

    Raises
    ------
    ValueError
        If a time is not positive and finite.
    """
    decay = np.exp(-np.outer(spectrum.eigenvalues, checked_times(times)))
    return spectrum.eigenvectors**2 @ decay
