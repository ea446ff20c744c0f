# SPDX-License-Identifier: MIT
"""Heat kernels as sums over the eigenpairs of a truncated spectrum (paper, section 3.1)."""

from __future__ import annotations

from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike

from shapegoogle_core.api.arguments import check_number
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral.spectrum import Spectrum

__all__ = ["check_source", "checked_time", "checked_times", "truncated_diagonal", "truncated_kernel"]


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
        If there are none, more axes than one, or a time is not positive and finite.
    """
    try:
        array = np.atleast_1d(np.asarray(times, dtype=np.float64))
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.ndim != 1 or not len(array) or not (np.isfinite(array).all() and (array > 0).all()):
        raise ValueError("times must be a list of positive numbers, in squared mesh units")
    return array


def checked_time(time: float) -> FloatArray:
    """Convert a time to an array and check that it is positive.

    Parameters
    ----------
    time : float
        In squared mesh units.

    Returns
    -------
    times : (1,) array

    Raises
    ------
    ValueError
        If it is not a positive number.
    """
    check_number("time", time, positive=True)
    return np.array([time], dtype=np.float64)


def check_source(source: object, count: int) -> None:
    """Raise ValueError unless a source of heat is a vertex.

    Parameters
    ----------
    source : object
    count : int
        Number of vertices.

    Raises
    ------
    ValueError
        If it is not a whole number from 0 to `count` - 1.
    """
    if not (isinstance(source, Integral) and 0 <= int(source) < count):
        raise ValueError(f"source must be a vertex from 0 to {count - 1}, not {source!r}")


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
    check_source(source, len(spectrum.mass))
    decay = np.exp(-spectrum.eigenvalues * checked_time(time))
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
