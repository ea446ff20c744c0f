# SPDX-License-Identifier: MIT
"""Factorisations of W - σA, and the numbers of eigenvalues below σ, which they count (Sylvester)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import SuperLU, splu

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral.pencil import Pencil

__all__ = ["CLUSTER", "Factor", "countable_gap", "factor_inside", "factorise"]

# Share of the wanted eigenvalues that σ should leave below it: more than half, as nothing lies beyond them,
# so that they converge sooner than those at the upper end. Between the bounds another factorisation does not
# pay.
SHARE_BELOW = 0.6
LEAST_BELOW, MOST_BELOW = 0.35, 0.85
# Up to this number of pairs σ lies above all of them: it should leave `SPARE` more below it, and at most
# `MOST_SPARE` more.
FEW_PAIRS = 20
SPARE, MOST_SPARE = 3, 12
# Relative distance below which eigenvalues are counted as one.
CLUSTER = 1e-9


@dataclass(frozen=True, eq=False)
class Factor:
    """Factorisation of W - σA."""

    shift: float
    lu: SuperLU
    below: int  # number of eigenvalues below the shift


def countable_gap(values: FloatArray, following: float, k: int, rounding: float) -> tuple[float, int]:
    """Choose a gap among the eigenvalues at which to count, and say how many lie below it.

    The first gap above the k-th eigenvalue; or the last gap below it if it belongs to a cluster that
    continues beyond the eigenvalues found. Those that could be missing above the bound then equal the cluster
    within `CLUSTER`. Differences below `rounding` separate nothing.
    """
    edges = np.append(values, following)
    gaps = np.diff(edges)
    # Number of eigenvalues below each wide gap.
    below = np.flatnonzero(gaps > CLUSTER * np.abs(edges[1:]) + rounding) + 1
    if not len(below):
        return float(values[0] - CLUSTER * abs(values[0]) - rounding), 0
    expected = int(below[below >= k][0] if below[-1] >= k else below[-1])
    # Near the lower end of the gap: the next value has not converged, and will be smaller when it has.
    return float(values[expected - 1] + 0.25 * gaps[expected - 1]), expected


def factorise(pencil: Pencil, shift: float, earlier: Factor | None = None) -> Factor:
    """Factorise W - σA without exchanging rows, which keeps the pivots' signs those of D in LDLᵀ.

    Parameters
    ----------
    pencil : Pencil
    shift : float
        σ.
    earlier : Factor, optional
        With another shift. Its order of elimination is used again, which saves the search for one. The result
        belongs to the matrix in that order, and serves for counting only.

    Raises
    ------
    numpy.linalg.LinAlgError
        If a pivot is exactly zero.
    """
    matrix = pencil.shifted(shift)
    if earlier is not None:
        elimination = np.argsort(earlier.lu.perm_c)
        matrix = sparse.csc_matrix(matrix[elimination][:, elimination])
    try:
        lu = splu(
            matrix,
            permc_spec="MMD_AT_PLUS_A" if earlier is None else "NATURAL",
            diag_pivot_thresh=0.0,
            # The supernodes of a surface are small: SuperLU's larger defaults are slower.
            relax=1,
            panel_size=1,
            options={"SymmetricMode": True},
        )
    except RuntimeError as error:  # "Factor is exactly singular"
        raise np.linalg.LinAlgError(f"the matrix is singular at the shift {shift:.6g}") from error
    if not np.array_equal(lu.perm_r, lu.perm_c):
        raise np.linalg.LinAlgError(f"a pivot is zero at the shift {shift:.6g}")
    return Factor(shift, lu, int((lu.U.diagonal() < 0).sum()))


def factor_inside(pencil: Pencil, k: int, random: np.random.Generator) -> Factor:
    """Factorise at a shift inside the k smallest eigenvalues, or just above them if they are few.

    If none suits, the shift lies below all eigenvalues.
    """
    inside = LEAST_BELOW * k, SHARE_BELOW * k, MOST_BELOW * k
    above = float(k), float(k + SPARE), float(k + MOST_SPARE)
    least, aim, most = above if k <= FEW_PAIRS else inside
    shift = aim * pencil.spacing
    for _ in range(5):
        try:
            factor = factorise(pencil, shift)
        except np.linalg.LinAlgError:
            shift += 0.3 * pencil.spacing
            continue
        if least <= factor.below <= most:
            if _is_accurate(pencil, factor, random):
                return factor
            shift += 0.3 * pencil.spacing
        else:  # Weyl's law is far off, as on a long strip or thin sheets
            shift *= min(max(aim / max(factor.below, 0.5), 0.25), 4.0)
    # Relative to the area, so that W - σA is positive definite in any unit.
    return factorise(pencil, -0.05 * pencil.spacing)


def _is_accurate(pencil: Pencil, factor: Factor, random: np.random.Generator) -> bool:
    """Tell whether a factorisation without row exchanges is stable, and its shift not at an eigenvalue.

    A θ far larger than the others would spread its rounding error to them.
    """
    right_side = pencil.weigh(random.standard_normal((pencil.stiffness.shape[0], 1)))
    solution = factor.lu.solve(right_side)
    matrix = pencil.shifted(factor.shift)
    size = abs(matrix).sum(axis=0).max() * np.abs(solution).max()
    again = factor.lu.solve(pencil.weigh(solution))
    largest_theta = np.linalg.norm(again) / np.linalg.norm(solution)
    stable = np.abs(matrix @ solution - right_side).max() < 1e-11 * size
    return bool(stable and largest_theta * pencil.spacing < 1e3)
