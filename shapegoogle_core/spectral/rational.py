# SPDX-License-Identifier: MIT
"""Heat kernels of the full spectrum at any time, without computing the spectrum (paper, section 3.3).

With k eigenpairs the heat kernel is known only at times at which all other eigenpairs have decayed. For
smaller times the paper cites a multiresolution approach (Vaxman, Ben-Chen, Gotsman 2010). Here K_t is instead
a sum of resolvents R(z) = (W + zA)⁻¹, the Green's functions of the screened Poisson equation. For real z > 0
in a geometric ladder, the same for all times,

    exp(-tλ) ≈ Σ_j c_j(t) z_j z_{j+1} / ((λ + z_j) (λ + z_{j+1})) for all λ ≥ 0, and so
    K_t      ≈ Σ_j c_j(t) P_j,  P_j = z_j z_{j+1} (R(z_j) - R(z_{j+1})) / (z_{j+1} - z_j)

Each W + zA is sparse and positive definite: a column of K_t takes one solution with each of them, all
K_t(x, x) take the diagonal of each inverse. Fractions of products fall as 1/λ², and so does the error of
exp(-tλ), at most ε / (1 + tλ)². Over the spectrum of a surface this sums up to some ε K_t(x, x), whatever
its mesh; P_j bounds it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian import Operator, factor_definite
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral.selected_inverse import Levels, inverse_diagonal, level_structure
from shapegoogle_core.spectral.spectrum import Spectrum
from shapegoogle_core.spectral.truncated import check_source, checked_time, checked_times, truncated_diagonal

__all__ = ["rational_diagonal", "rational_kernel"]

# A time t takes the poles z from 2^-1/t to 2^7/t. With more of them in an octave rounding sets the limit,
# with fewer the error ε grows quickly (docs/concepts/small_times.md).
OCTAVES = (-1, 7)
POLES_PER_OCTAVE = 2.5
# Latest time, as a multiple of the area: beyond it W + zA is so nearly singular that rounding would count.
LATEST = 10.0


@dataclass(frozen=True, eq=False)
class _Ladder:
    """Poles of resolvents, and the weights that turn these into heat kernels.

    Attributes
    ----------
    poles : (p,) array
        z, ascending, in 1 / squared mesh units.
    weights : (p - 1, d) array
        c of each pair of neighbouring poles, for each of d times; dimensionless. Many are 0.
    errors : (d,) array
        ε, the largest error of exp(-tλ) as a multiple of 1 / (1 + tλ)².
    bounding : (d,) array of int
        Index j of a pair for which 1 / (1 + tλ)² ≤ z_j z_{j+1} / ((λ + z_j) (λ + z_{j+1})), so that the error
        of K_t(x, x) is at most ε P_j(x, x).
    above : (d,) array of int
        The same for (1 + tλ/2)⁻², which is at least exp(-tλ), so that K_t(x, x) is at most P_j(x, x).
    """

    poles: FloatArray
    weights: FloatArray
    errors: FloatArray
    bounding: NDArray[np.int64]
    above: NDArray[np.int64]

    def pairs(self, resolvent: Callable[[float], FloatArray]) -> Iterator[FloatArray]:
        """Yield P_j of each pair of poles, of the part of the resolvents that `resolvent` computes."""
        lower, lower_part = self.poles[0], resolvent(self.poles[0])
        for pole in self.poles[1:]:
            part = resolvent(pole)
            yield lower * pole / (pole - lower) * (lower_part - part)
            lower, lower_part = pole, part


def rational_kernel(operator: Operator, source: int, time: float, tolerance: float = 0.01) -> FloatArray:
    """Compute a row of the heat kernel, K_t(x, y) = Σ_l exp(-λ_l t) φ_l(x) φ_l(y) over all eigenpairs.

    Parameters
    ----------
    operator : Operator
        With n vertices, see `build_operator`.
    source : int
        Vertex x.
    time : float
        t > 0, in squared mesh units, at most ten times the area.
    tolerance : float
        Largest error as a share of √(K_t(x, x) K_t(y, y)), which the kernel itself nowhere exceeds.

    Returns
    -------
    heat : (n,) array
        K_t(x, y) for all y, in 1 / squared mesh units. Its integral is 1.

    Raises
    ------
    ValueError
        If a parameter is out of range, the operator has values elsewhere than at vertices ("fem2", "fem3"),
        or the tolerance cannot be proved.
    """
    t = _small_times(operator, checked_time(time))
    _check_operator_and_tolerance(operator, tolerance)
    n = len(operator.lumped_mass)
    check_source(source, n)
    # In this order of small bandwidth the factorisations are far faster than in that of the mesh.
    order = level_structure(_pattern(operator)).order
    stiffness = operator.stiffness[order][:, order]
    mass = operator.mass[order][:, order]
    place = int(np.flatnonzero(order == source)[0])
    unit = np.zeros(n)
    unit[place] = 1.0

    def column(pole: float) -> FloatArray:
        factor = factor_definite(sparse.csc_matrix(stiffness + pole * mass))
        return factor.solve(unit)

    ladder = _ladder(t)
    heat, bound = np.zeros(n), np.empty(1)
    for index, pair in enumerate(ladder.pairs(column)):
        heat += ladder.weights[index, 0] * pair
        if index == ladder.bounding[0]:
            bound = ladder.errors * pair[place]
    _check_proof(bound, heat[[place]], tolerance)
    values = np.empty(n)
    values[order] = heat
    return values


def rational_diagonal(
    operator: Operator, times: ArrayLike, spectrum: Spectrum | None = None, tolerance: float = 0.01
) -> FloatArray:
    """Compute the diagonal of the heat kernel, K_t(x, x) = Σ_l exp(-λ_l t) φ_l(x)² over all eigenpairs.

    Parameters
    ----------
    operator : Operator
        With n vertices, see `build_operator`.
    times : (d,) array_like
        Times t > 0, in squared mesh units. Without a spectrum they are at most ten times the area.
    spectrum : Spectrum, optional
        The operator's spectrum, of any size. The values at times at which what it leaves out is proved to be
        within the tolerance are taken from it.
    tolerance : float
        Largest error as a share of K_t(x, x), proved at every vertex and time, rounding aside.

    Returns
    -------
    values : (n, d) array
        In 1 / squared mesh units.

    Raises
    ------
    ValueError
        If a parameter is out of range, the spectrum is of another operator, the operator has values elsewhere
        than at vertices ("fem2", "fem3"), or the tolerance cannot be proved, which happens on very uneven
        meshes.
    MeshError
        If the stiffness has negative eigenvalues.
    """
    _check_operator_and_tolerance(operator, tolerance)
    mass = operator.lumped_mass
    if spectrum is not None and not (
        len(spectrum.mass) == len(mass) and np.allclose(spectrum.mass, mass, rtol=1e-6, atol=0)
    ):
        raise ValueError(
            "the spectrum is of another mesh or Laplacian than the operator; pass that of the operator"
        )
    levels = level_structure(_pattern(operator))
    if spectrum is None:
        return _by_resolvents(operator, levels, _small_times(operator, times), tolerance)
    values = truncated_diagonal(spectrum, times)
    t = checked_times(times)
    beyond = (_left_out(operator, levels, spectrum, t) > tolerance * values).any(axis=0)
    if beyond.any():
        below = _small_times(operator, t[beyond])
        values[:, beyond] = _by_resolvents(operator, levels, below, tolerance)
    return values


def _by_resolvents(operator: Operator, levels: Levels, times: FloatArray, tolerance: float) -> FloatArray:
    """Compute K_t(x, x), an (n, d) array, from the diagonals of the resolvents."""
    shape = len(levels.order), len(times)
    values, bounds, above = np.zeros(shape), np.empty(shape), np.empty(shape)
    ladder = _ladder(times)
    for index, pair in enumerate(ladder.pairs(lambda pole: _resolvent_diagonal(operator, levels, pole))):
        values += np.outer(pair, ladder.weights[index])
        bounded = ladder.bounding == index
        bounds[:, bounded] = np.outer(pair, ladder.errors[bounded])
        above[:, ladder.above == index] = pair[:, None]
    # Heat never falls below its mean. This and the bound from above are accurate also where a component is so
    # small for the time that the sum of resolvents suffers from rounding.
    _, component = connected_components(operator.stiffness, directed=False)
    mean = 1 / np.bincount(component, operator.lumped_mass)[component]
    values = np.maximum(np.minimum(values, above), mean[:, None])
    _check_proof(bounds, values, tolerance)
    return values


def _left_out(operator: Operator, levels: Levels, spectrum: Spectrum, times: FloatArray) -> FloatArray:
    """Bound the part of K_t(x, x) that the truncated spectrum lacks, as an (n, d) array.

    For λ ≥ λ_k the product (λ + λ_k) exp(-λt) is at most 2 λ_k exp(-λ_k t), if 2 λ_k t ≥ 1. The sum over
    l > k of exp(-λ_l t) φ_l² is then at most that times the sum of φ_l² / (λ_l + λ_k): the diagonal of the
    resolvent R(λ_k), less the part of the known pairs.
    """
    n, k = spectrum.eigenvectors.shape
    if k == n:
        return np.zeros((n, len(times)))
    last = float(spectrum.eigenvalues[-1])
    if last <= 0:  # some components have no eigenpair at all
        return np.full((n, len(times)), np.inf)
    known = spectrum.eigenvectors**2 @ (1 / (spectrum.eigenvalues + last))
    unknown = np.maximum(_resolvent_diagonal(operator, levels, last) - known, 0)
    largest = np.where(2 * last * times >= 1, 2 * last * np.exp(-last * times), np.inf)
    return unknown[:, None] * largest


def _resolvent_diagonal(operator: Operator, levels: Levels, pole: float) -> FloatArray:
    try:
        return inverse_diagonal(sparse.csr_array(operator.stiffness + pole * operator.mass), levels)
    except np.linalg.LinAlgError as error:
        raise MeshError(
            "the stiffness of the operator has negative eigenvalues; use another Laplacian, such as 'robust'"
        ) from error


def _ladder(times: FloatArray) -> _Ladder:
    """Fit exp(-tλ) for each time."""
    low, high = OCTAVES
    shortest, longest = times.min(), times.max()
    steps = np.arange(
        np.ceil((low - np.log2(longest / shortest)) * POLES_PER_OCTAVE), high * POLES_PER_OCTAVE + 1
    )
    poles = 2 ** (steps / POLES_PER_OCTAVE) / shortest
    near = (poles[:, None] * times >= 2.0**low) & (poles[:, None] * times <= 2.0**high)
    poles, near = poles[near.any(axis=1)], near[near.any(axis=1)]
    # λt from where exp(-λt) is flat to where all fractions have the same slope, and points between these.
    fitted = np.concatenate([[0.0], np.geomspace(1e-3, 1e6, 400)])
    tried = np.concatenate([[0.0], np.geomspace(1e-4, 1e8, 4000)])
    importance = (1 + fitted) ** 2
    importance[0] = 1e4  # heat is conserved: the fit at λ = 0 is the integral of the kernel
    weights, errors = np.zeros((len(poles) - 1, len(times))), np.empty(len(times))
    for column, time in enumerate(times):
        scaled = poles[near[:, column]] * time
        system = importance[:, None] * _fractions(fitted, scaled)
        solution = np.linalg.lstsq(system, importance * np.exp(-fitted), rcond=1e-15)[0]
        errors[column] = np.abs(
            (1 + tried) ** 2 * (_fractions(tried, scaled) @ solution - np.exp(-tried))
        ).max()
        first = int(near[:, column].argmax())
        weights[first : first + len(solution), column] = solution
    # z z' / ((λ + z) (λ + z')) is at least (1 + sλ)⁻² if 1/z + 1/z' ≤ 2s.
    slopes = 1 / poles[:-1] + 1 / poles[1:]
    bounding = (slopes[:, None] <= 2 * times).argmax(axis=0)
    above = (slopes[:, None] <= times).argmax(axis=0)
    return _Ladder(poles, weights, errors, bounding, above)


def _fractions(values: FloatArray, poles: FloatArray) -> FloatArray:
    """Compute z_j z_{j+1} / ((λ + z_j) (λ + z_{j+1})) for each λ and each pair of neighbouring poles."""
    single = poles / (values[:, None] + poles)
    return single[:, :-1] * single[:, 1:]


def _small_times(operator: Operator, times: ArrayLike) -> FloatArray:
    """Raise ValueError if there are no times, or one is later than the method serves."""
    t = checked_times(times)
    area = float(operator.lumped_mass.sum())
    if (t > LATEST * area).any():
        raise ValueError(
            f"the time {t.max():g} is more than {LATEST:g} times the area, {area:g}; use method='spectral'"
        )
    return t


def _check_operator_and_tolerance(operator: Operator, tolerance: float) -> None:
    if operator.stiffness.shape[0] != len(operator.lumped_mass):
        raise ValueError(
            "method='rational' needs an operator with a value for each vertex, not 'fem2' or 'fem3'; "
            "use 'fem1' on a finer mesh"
        )
    if not 0 < tolerance < 1:
        raise ValueError(f"tolerance must be between 0 and 1, not {tolerance}")


def _check_proof(bounds: FloatArray, values: FloatArray, tolerance: float) -> None:
    """Raise ValueError unless errors of at most `bounds` are within the tolerance, as shares of the values.

    Vertices with far less area than their neighbours are hard: their heat falls as fast as exp(-tλ), and the
    bound does not.
    """
    least = values - bounds
    proved = float((bounds / least).max()) if least.min() > 0 else math.inf
    if proved > tolerance:
        advice = f"allow {1.1 * proved:.2g}, or re-mesh it" if proved < 0.5 else "re-mesh it first"
        raise ValueError(f"a tolerance of {tolerance:g} cannot be proved on a mesh this uneven; {advice}")


def _pattern(operator: Operator) -> sparse.csr_array:
    """Mark the pairs of vertices that a resolvent joins, also where their weights happen to be 0."""
    parts = [matrix.tocsr(copy=True) for matrix in (operator.stiffness, operator.mass)]
    for part in parts:
        part.data = np.ones(part.nnz)
    return sparse.csr_array(parts[0] + parts[1])
