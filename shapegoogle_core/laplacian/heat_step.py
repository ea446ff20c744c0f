# SPDX-License-Identifier: MIT
"""Heat that flows over a surface in implicit steps."""

from __future__ import annotations

from scipy.sparse import csc_array, csc_matrix, diags_array
from scipy.sparse.linalg import SuperLU, splu

from shapegoogle_core.laplacian.operator import Operator

__all__ = ["factor_definite", "heat_step"]


def factor_definite(matrix: csc_array | csc_matrix) -> SuperLU:
    """Factorise a symmetric matrix with a positive definite (real part of it).

    Without pivoting, and with an ordering for symmetric patterns.

    Parameters
    ----------
    matrix : (n, n) sparse array

    Returns
    -------
    factor : SuperLU
        ``factor.solve(b)`` is x of M x = b.
    """
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def heat_step(operator: Operator, time: float) -> SuperLU:
    """Factorise A + t W, with the areas A and the stiffness W: an implicit step of heat flow.

    Parameters
    ----------
    operator : Operator
        Its mass is lumped.
    time : float
        t ≥ 0, in squared mesh units.

    Returns
    -------
    factor : SuperLU
        ``factor.solve(A f)`` is f a step later: A f' + t W f' = A f.
    """
    return factor_definite(csc_array(diags_array(operator.lumped_mass) + time * operator.stiffness))
