# SPDX-License-Identifier: MIT
"""Implicit steps of heat flow over a surface."""

from __future__ import annotations

from scipy.sparse import csc_array, csc_matrix, diags_array
from scipy.sparse.linalg import SuperLU, splu

from shapegoogle_core.laplacian.operator import Operator

__all__ = ["factor_definite", "heat_step"]


def factor_definite(matrix: csc_array | csc_matrix) -> SuperLU:
    """Factorise a symmetric positive definite matrix.

    Without pivoting, and with an ordering for symmetric patterns.

    Parameters
    ----------
    matrix : (n, n) sparse array
        Symmetric. If it is complex, its real part is positive definite.

    Returns
    -------
    factor : SuperLU
        ``factor.solve(b)`` is the solution x of M x = b.
    """
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def heat_step(operator: Operator, time: float) -> SuperLU:
    """Factorise A + t W, the matrix of an implicit step of heat flow.

    Parameters
    ----------
    operator : Operator
        Areas A and stiffness W. Its mass is lumped.
    time : float
        t ≥ 0, in squared mesh units.

    Returns
    -------
    factor : SuperLU
        ``factor.solve(A f)`` is f after the step: A f' + t W f' = A f.
    """
    return factor_definite(csc_array(diags_array(operator.lumped_mass) + time * operator.stiffness))
