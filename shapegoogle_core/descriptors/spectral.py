# SPDX-License-Identifier: MIT
"""Descriptors of every vertex, computed from the spectrum (paper, sections 3.1 and 3.2)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import Spectrum

__all__ = [
    "global_point_signature",
    "heat_kernel",
    "heat_kernel_signature",
    "log_heat_kernel_signature",
    "scale_invariant_hks",
    "wave_kernel_signature",
]

# A component left out of the truncated spectrum has no heat at all; e⁻¹⁰ stands for that.
LEAST_HEAT = math.exp(-10)


def _positive_times(times: ArrayLike) -> FloatArray:
    array = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if array.ndim != 1 or not (np.isfinite(array).all() and (array > 0).all()):
        raise ValueError("times must be a list of positive numbers, in squared mesh units")
    return array


def heat_kernel(spectrum: Spectrum, source: int, time: float) -> FloatArray:
    """Heat at every vertex, a time after a unit of it was put on one vertex (paper, equation 5).

    K_t(x, y) = Σ_l exp(-λ_l t) φ_l(x) φ_l(y)

    Parameters
    ----------
    spectrum : Spectrum
    source : int
        Vertex x.
    time : float
        t > 0, in squared mesh units.

    Returns
    -------
    heat : (n,) array
        K_t(x, y) for all y, in 1 / squared mesh units; its integral is 1, unless the component of x was left
        out of the spectrum.
    """
    decay = np.exp(-spectrum.eigenvalues * _positive_times(time))
    heat: FloatArray = spectrum.eigenvectors @ (decay * spectrum.eigenvectors[source])
    return heat


def heat_kernel_signature(
    spectrum: Spectrum, times: ArrayLike, *, multiply_by_time: bool = False, normalize: bool = False
) -> FloatArray:
    """Heat kernel signature of every vertex (paper, equations 2 and 6; Sun, Ovsjanikov, Guibas 2009).

    K_t(x, x) = Σ_l exp(-λ_l t) φ_l(x)²

    Parameters
    ----------
    spectrum : Spectrum
    times : (d,) array_like
        Times t > 0, in squared mesh units.
    multiply_by_time : bool
        Return t·K_t(x, x), which has no unit.
    normalize : bool
        Scale the values of each vertex to unit Euclidean norm: the c(x) of equation 2.

    Returns
    -------
    values : (n, d) array
        In 1 / squared mesh units, unless one of the options removes the unit.
    """
    t = _positive_times(times)
    values: FloatArray = spectrum.eigenvectors**2 @ np.exp(-np.outer(spectrum.eigenvalues, t))
    if multiply_by_time:
        values *= t
    if normalize:
        values /= np.maximum(np.linalg.norm(values, axis=1, keepdims=True), np.finfo(float).tiny)
    return values


def log_heat_kernel_signature(spectrum: Spectrum, times: ArrayLike) -> FloatArray:
    """Logarithm of the heat kernel signature, which has no unit.

    log(t·K_t(x, x)), where that is not below e⁻¹⁰

    Parameters
    ----------
    spectrum : Spectrum
    times : (d,) array_like
        Times t > 0, in squared mesh units.

    Returns
    -------
    signature : (n, d) array
        ≥ -10: where the truncated spectrum has no heat at all, -10 stands for that.
    """
    kernel = heat_kernel_signature(spectrum, times, multiply_by_time=True)
    values: FloatArray = np.log(np.maximum(kernel, LEAST_HEAT))
    return values


def scale_invariant_hks(
    spectrum: Spectrum,
    *,
    alpha: float = 2.0,
    tau: ArrayLike | None = None,
    frequencies: int = 6,
) -> FloatArray:
    """Scale-invariant heat kernel signature of every vertex (paper, equation 3; Bronstein, Kokkinos 2010).

    With t = α^τ, scaling a shape shifts log K along τ and adds a constant. Differences along τ remove the
    constant, the modulus of the Fourier transform removes the shift:
    |F{log K_{α^(τ+Δτ)}(x, x) - log K_{α^τ}(x, x)}(ω)|.

    Parameters
    ----------
    spectrum : Spectrum
        How many eigenpairs it has is part of the definition: at small t the kernel is truncated.
    alpha : float
        Base of the logarithmic scale, > 1.
    tau : (s,) array_like, optional
        Evenly spaced exponents; t = α^τ in squared mesh units. Default 1 to 25 in steps of 1/16, made for
        shapes of some 10⁴ squared units (TOSCA); other units need other exponents.
    frequencies : int
        How many of the lowest frequencies to keep, from ω = 0.

    Returns
    -------
    values : (n, frequencies) array
        Without unit.

    Raises
    ------
    ValueError
        If `tau` has too few values for the frequencies, or a parameter is out of range.
    """
    exponents = np.arange(1.0, 25.0 + 1 / 32, 1 / 16) if tau is None else np.asarray(tau, dtype=np.float64)
    if (
        exponents.ndim != 1
        or len(exponents) < 3
        or not np.allclose(np.diff(exponents), np.diff(exponents)[0])
    ):
        raise ValueError("tau must hold at least 3 evenly spaced values")
    if alpha <= 1:
        raise ValueError(f"alpha must be greater than 1, not {alpha}")
    samples = len(exponents) - 1
    if not 1 <= frequencies <= samples // 2 + 1:
        raise ValueError(
            f"frequencies must be between 1 and {samples // 2 + 1} for {samples + 1} values of tau"
        )
    # The kernel is positive; a vertex on a component left out of the truncated spectrum gets zeros.
    kernel = heat_kernel_signature(spectrum, alpha**exponents)
    log_kernel = np.log(np.maximum(kernel, np.finfo(float).tiny))
    differences = np.diff(log_kernel, axis=1)
    # Only a few rows of the transform are wanted: a thin matrix product beats a full FFT.
    waves = np.exp(-2j * np.pi * np.outer(np.arange(samples), np.arange(frequencies)) / samples)
    values: FloatArray = np.hypot(differences @ waves.real, differences @ waves.imag)
    return values


def wave_kernel_signature(
    spectrum: Spectrum, energies: int | ArrayLike = 100, *, sigma: float | None = None
) -> FloatArray:
    """Wave kernel signature of every vertex (Aubry, Schlickewei, Cremers 2011).

    WKS(x, e) = Σ_l exp(-(e - log λ_l)² / 2σ²) φ_l(x)² / Σ_l exp(-(e - log λ_l)² / 2σ²)

    Parameters
    ----------
    spectrum : Spectrum
    energies : int or (d,) array_like
        The values e (logarithms of eigenvalues in 1 / squared mesh units), or how many to take: evenly
        from the logarithm of the first positive eigenvalue to that of the last, 2σ inside them.
    sigma : float, optional
        Width in logarithmic energy. Default, for a number of energies: 7 of their steps.

    Returns
    -------
    values : (n, d) array
        In 1 / squared mesh units.

    Raises
    ------
    ValueError
        If the spectrum has fewer than two positive eigenvalues, or explicit energies come without sigma.
    """
    # The zeros of the components have no logarithm; relative to the largest, so in any unit.
    positive = spectrum.eigenvalues > 1e-8 * spectrum.eigenvalues[-1]
    if positive.sum() < 2:
        raise ValueError("the wave kernel signature needs at least two positive eigenvalues")
    log_eigenvalues = np.log(spectrum.eigenvalues[positive])
    if np.ndim(energies) == 0:
        count = int(np.asarray(energies))
        if count < 1:
            raise ValueError(f"energies must be at least 1, not {count}")
        low, high = log_eigenvalues[0], log_eigenvalues[-1]
        if sigma is None:
            # σ = 7 steps and a margin of 2σ at both ends: high - low = (energies - 1 + 28) steps.
            sigma = 7 * (high - low) / (count + 27)
        grid = np.linspace(low + 2 * sigma, high - 2 * sigma, count)
    else:
        grid = np.atleast_1d(np.asarray(energies, dtype=np.float64))
        if sigma is None:
            raise ValueError("explicit energies need an explicit sigma")
    if not sigma > 0:
        raise ValueError(f"sigma must be positive, not {sigma}")
    exponents = -((grid[None, :] - log_eigenvalues[:, None]) ** 2) / (2 * sigma**2)
    weights = np.exp(exponents - exponents.max(axis=0))  # shifted, so that no column underflows to zeros
    weights /= weights.sum(axis=0)
    values: FloatArray = spectrum.eigenvectors[:, positive] ** 2 @ weights
    return values


def global_point_signature(spectrum: Spectrum, count: int = 25) -> FloatArray:
    """Global point signature of every vertex (Rustamov 2007).

    GPS(x) = (φ₁(x)/√λ₁, φ₂(x)/√λ₂, …) over the positive eigenvalues

    Distances between signatures come from the Green's function of the surface, so they are intrinsic; a
    single number is not: an eigenfunction has no sign of its own, and those of one eigenvalue any basis.

    Parameters
    ----------
    spectrum : Spectrum
    count : int
        How many eigenfunctions.

    Returns
    -------
    values : (n, count) array
        Without unit: the size of the shape does not matter. A coarse mesh has fewer eigenfunctions; 0, to
        which the values fall, stands for the others.

    Raises
    ------
    ValueError
        If count < 1.
    """
    if count < 1:
        raise ValueError(f"a global point signature needs at least one eigenfunction, not {count}")
    # Relative to the largest, so in any unit: the zeros of the parts have no square root to divide by.
    positive = np.flatnonzero(spectrum.eigenvalues > 1e-8 * spectrum.eigenvalues[-1])[:count]
    values = np.zeros((len(spectrum.mass), count))
    values[:, : len(positive)] = spectrum.eigenvectors[:, positive] / np.sqrt(spectrum.eigenvalues[positive])
    return values
