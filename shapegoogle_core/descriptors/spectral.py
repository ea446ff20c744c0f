# SPDX-License-Identifier: MIT
"""Local descriptors computed from the spectrum (paper, sections 3.1 and 3.2)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from shapegoogle_core.api.arguments import check_count
from shapegoogle_core.descriptors.times import default_exponents, default_times
from shapegoogle_core.laplacian import Operator
from shapegoogle_core.mesh import MeshLike
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral import Spectrum, check_spectrum, checked_shape, heat_kernel_diagonal
from shapegoogle_core.spectral.truncated import checked_times

__all__ = [
    "global_point_signature",
    "heat_kernel_signature",
    "log_heat_kernel_signature",
    "scale_invariant_hks",
    "wave_kernel_signature",
]

# Least value under a logarithm: a component left out of the truncated spectrum has no heat at all.
LEAST_HEAT = math.exp(-10)


def heat_kernel_signature(
    shape: Spectrum | Operator | MeshLike,
    times: ArrayLike | None = None,
    *,
    multiply_by_time: bool = False,
    normalize: bool = False,
    method: str = "spectral",
    spectrum: Spectrum | None = None,
    tolerance: float = 0.01,
) -> FloatArray:
    """Heat kernel signature of every vertex (paper, equations 2 and 6; Sun, Ovsjanikov, Guibas 2009).

    p(x) = c(x) (K_t1(x, x), …, K_td(x, x)) with K_t(x, x) = Σ_l exp(-λ_l t) φ_l(x)²

    Parameters
    ----------
    shape : Spectrum, Operator or MeshLike
        A `Spectrum` for the method "spectral"; an operator with a value for each vertex, see
        `build_operator`, or a mesh for the method "rational".
    times : (d,) array_like, optional
        Times t > 0, in squared mesh units; with "rational" and without a spectrum at most ten times the area.
        Default: 100 times, see `default_times`; "rational" then needs a spectrum.
    multiply_by_time : bool
        Return t·K_t(x, x), which has no unit.
    normalize : bool
        Scale the values of each vertex to unit Euclidean norm, the c(x) of equation 2. Otherwise c(x) = 1.
    method : {"spectral", "rational"}
        "spectral" sums over the eigenpairs of the spectrum, exact once the omitted terms have decayed.
        "rational" gives the sum over all eigenpairs, of which few or none are computed, at any time however
        small.
    spectrum : Spectrum, optional
        Of "rational" only: the operator's spectrum, of any size. The values at times at which what it leaves
        out is proved to be within the tolerance are taken from it.
    tolerance : float
        Of "rational" only: largest error as a share of K_t(x, x), proved at every vertex and time, rounding
        aside. The error is usually a hundred times smaller.

    Returns
    -------
    values : (n, d) array
        In 1 / squared mesh units, unless one of the options removes the unit.

    Raises
    ------
    ValueError
        If the method is unknown or needs another kind of shape, a time is not positive, or, with
        "rational", times and spectrum are missing,
        another parameter is out of range, the spectrum is of another operator, the operator has values
        elsewhere than at vertices ("fem2", "fem3"), or the tolerance cannot be proved, which happens on very
        uneven meshes.
    MeshError
        If the operator of the mesh cannot be assembled, or there are no default times as all eigenvalues
        are 0, or the stiffness of the operator has negative eigenvalues.

    See Also
    --------
    heat_kernel : Heat that comes from one vertex, K_t(x, y).
    scale_invariant_hks : Signature that does not change with the size of a shape.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> vertices = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    >>> tetrahedron = sg.Mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    >>> spectrum = sg.compute_spectrum(tetrahedron)
    >>> sg.heat_kernel_signature(spectrum, [0.5, 5.0]).round(3).tolist()[0]
    [0.227, 0.08]
    >>> sg.heat_kernel_signature(spectrum).shape
    (4, 100)
    >>> exact = sg.heat_kernel_signature(tetrahedron, [0.5, 5.0], method="rational")
    >>> exact.round(3).tolist()[0]
    [0.227, 0.08]
    """
    shape = checked_shape(shape, method)
    if times is None:
        known = shape if isinstance(shape, Spectrum) else spectrum
        if known is None:
            raise ValueError("without a spectrum there are no default times; pass times or spectrum")
        times = default_times(known)
    values = heat_kernel_diagonal(shape, times, method=method, spectrum=spectrum, tolerance=tolerance)
    if multiply_by_time:
        values *= checked_times(times)
    if normalize:
        values /= np.maximum(np.linalg.norm(values, axis=1, keepdims=True), np.finfo(float).tiny)
    return values


def log_heat_kernel_signature(spectrum: Spectrum, times: ArrayLike) -> FloatArray:
    """Logarithm of the heat kernel signature of every vertex, dimensionless.

    log(t·K_t(x, x)), but at least -10

    Parameters
    ----------
    spectrum : Spectrum
        Eigenpairs of the shape.
    times : (d,) array_like
        Times t > 0, in squared mesh units.

    Returns
    -------
    signature : (n, d) array
        -10 where the truncated spectrum has no heat at all.

    Raises
    ------
    ValueError
        If the spectrum is not a `Spectrum`, or a time is not positive.

    See Also
    --------
    heat_kernel_signature : The signature itself.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> spectrum = sg.Spectrum(np.array([0.0, 1.0]), np.array([[0.6, 0.8], [0.8, -0.6]]), np.ones(2))
    >>> sg.log_heat_kernel_signature(spectrum, [0.5, 2.0]).round(3).tolist()
    [[-0.983, -0.113], [-0.846, 0.32]]
    """
    kernel = heat_kernel_signature(spectrum, times, multiply_by_time=True)
    return np.log(np.maximum(kernel, LEAST_HEAT))


def scale_invariant_hks(
    spectrum: Spectrum, *, alpha: float = 2.0, tau: ArrayLike | None = None, frequencies: int = 6
) -> FloatArray:
    """Scale-invariant heat kernel signature of every vertex (paper, equation 3; Bronstein, Kokkinos 2010).

    With t = α^τ, scaling a shape shifts log K along τ and adds a constant. Differences along τ remove the
    constant, and the modulus of the Fourier transform removes the shift:
    |F{log K_{α^(τ+Δτ)}(x, x) - log K_{α^τ}(x, x)}(ω)|

    Parameters
    ----------
    spectrum : Spectrum
        Eigenpairs of the shape. Their number is part of the definition: at small t the kernel is truncated.
    alpha : float
        α > 1, base of the logarithmic scale.
    tau : (s,) array_like, optional
        Evenly spaced exponents; t = α^τ in squared mesh units. Default: those of the default model for a
        shape of this area, see `default_exponents`. Bronstein and Kokkinos use 1 to 25 in steps of 1/16 for
        shapes of about 10⁴ squared units.
    frequencies : int
        Number of frequencies to keep: the lowest ones, from ω = 0.

    Returns
    -------
    values : (n, frequencies) array
        Dimensionless.

    Raises
    ------
    ValueError
        If the spectrum is not a `Spectrum`, `tau` has too few values for the frequencies, or a
        parameter is out of range.

    See Also
    --------
    heat_kernel_signature : Signature that changes with the size of a shape.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]])
    >>> faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    >>> small, large = (sg.compute_spectrum((scale * vertices, faces)) for scale in (1.0, 10.0))
    >>> values = sg.scale_invariant_hks(small)
    >>> values.shape, bool(np.allclose(sg.scale_invariant_hks(large), values))
    ((4, 6), True)
    """
    check_spectrum(spectrum)
    if alpha <= 1:
        raise ValueError(f"alpha must be greater than 1, not {alpha}")
    exponents = default_exponents(spectrum.area, alpha) if tau is None else np.asarray(tau, dtype=np.float64)
    if (
        exponents.ndim != 1
        or len(exponents) < 3
        or not np.allclose(np.diff(exponents), np.diff(exponents)[0])
    ):
        raise ValueError("tau must hold at least 3 evenly spaced values")
    samples = len(exponents) - 1
    if not 1 <= frequencies <= samples // 2 + 1:
        raise ValueError(
            f"frequencies must be between 1 and {samples // 2 + 1} for {samples + 1} values of tau"
        )
    # The kernel is positive, except on a component left out of the truncated spectrum, which gets zeros.
    kernel = heat_kernel_signature(spectrum, alpha**exponents)
    log_kernel = np.log(np.maximum(kernel, np.finfo(float).tiny))
    differences = np.diff(log_kernel, axis=1)
    # Only a few rows of the transform are needed: a thin matrix product is faster than a full FFT.
    waves = np.exp(-2j * np.pi * np.outer(np.arange(samples), np.arange(frequencies)) / samples)
    return np.asarray(np.hypot(differences @ waves.real, differences @ waves.imag))


def wave_kernel_signature(
    spectrum: Spectrum, energies: int | ArrayLike = 100, *, sigma: float | None = None
) -> FloatArray:
    """Wave kernel signature of every vertex (Aubry, Schlickewei, Cremers 2011).

    WKS(x, e) = Σ_l exp(-(e - log λ_l)² / 2σ²) φ_l(x)² / Σ_l exp(-(e - log λ_l)² / 2σ²)

    Parameters
    ----------
    spectrum : Spectrum
        Eigenpairs of the shape.
    energies : int or (d,) array_like
        The energies e (logarithms of eigenvalues in 1 / squared mesh units), or their number: they are then
        evenly spaced between the logarithms of the first positive eigenvalue and of the last, with a margin
        of 2σ at both ends.
    sigma : float, optional
        σ, width in logarithmic energy. Default, for a number of energies: 7 of their steps.

    Returns
    -------
    values : (n, d) array
        In 1 / squared mesh units.

    Raises
    ------
    ValueError
        If the spectrum is not a `Spectrum` or has fewer than two positive eigenvalues, the number of
        energies is less than 1, or explicit energies come without a positive sigma.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]])
    >>> spectrum = sg.compute_spectrum((vertices, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
    >>> values = sg.wave_kernel_signature(spectrum, 5)
    >>> values.shape
    (4, 5)
    >>> (values.T @ spectrum.mass).round(6).tolist()  # means of squared eigenfunctions
    [1.0, 1.0, 1.0, 1.0, 1.0]
    """
    check_spectrum(spectrum)
    # The zeros of the components have no logarithm. The bound is relative to the largest, for any unit.
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
    weights = np.exp(exponents - exponents.max(axis=0))  # shifted so that no column underflows to zeros
    weights /= weights.sum(axis=0)
    return np.asarray(spectrum.eigenvectors[:, positive] ** 2 @ weights)


def global_point_signature(spectrum: Spectrum, count: int = 25) -> FloatArray:
    """Global point signature of every vertex (Rustamov 2007).

    GPS(x) = (φ₁(x)/√λ₁, φ₂(x)/√λ₂, …) over the positive eigenvalues

    Distances between signatures come from the Green's function of the surface, so they are intrinsic. Single
    components are not: the sign of an eigenfunction is arbitrary, and so is the basis of an eigenspace.

    Parameters
    ----------
    spectrum : Spectrum
        Eigenpairs of the shape.
    count : int
        Number of eigenfunctions.

    Returns
    -------
    values : (n, count) array
        Dimensionless: the size of the shape does not matter. If the spectrum has fewer positive eigenvalues,
        the remaining columns are 0, the limit of the values.

    Raises
    ------
    ValueError
        If the spectrum is not a `Spectrum`, or count is not a whole number ≥ 1.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> spectrum = sg.Spectrum(np.array([0.0, 4.0]), np.array([[0.6, 0.8], [0.8, -0.6]]), np.ones(2))
    >>> sg.global_point_signature(spectrum, 2).round(3).tolist()
    [[0.4, 0.0], [-0.3, 0.0]]
    """
    check_spectrum(spectrum)
    check_count("count", count)
    # The zeros of the components are left out. The bound is relative to the largest, for any unit.
    positive = np.flatnonzero(spectrum.eigenvalues > 1e-8 * spectrum.eigenvalues[-1])[:count]
    values = np.zeros((len(spectrum.mass), count))
    values[:, : len(positive)] = spectrum.eigenvectors[:, positive] / np.sqrt(spectrum.eigenvalues[positive])
    return values
