# SPDX-License-Identifier: MIT
"""Stiffness and mass matrix of a Laplace–Beltrami operator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["BOUNDARIES", "Operator"]

BOUNDARIES = ("neumann", "dirichlet")
"""Conditions on open boundaries: no heat flows through them, or the function is held at 0 there."""


@dataclass(frozen=True, eq=False)
class Operator:
    """The pair (W, A) of the generalised eigenproblem W φ = λ A φ (paper, equations 8 and 10).

    Attributes
    ----------
    stiffness : (d, d) sparse array
        W, symmetric positive semi-definite, dimensionless; rows sum to 0. The first n of the d degrees of
        freedom are the values at the vertices of the mesh; most operators have no others.
    mass : (d, d) sparse array
        A, symmetric positive definite, in squared mesh units; sums to the area. Diagonal if lumped.
    vertex_areas : (n,) array, optional
        Area of each vertex in squared mesh units. None: d = n, and the areas are the row sums of `mass`.
    boundary : (b,) array of int, optional
        Degrees of freedom on the open boundary. None: it is not known.

    See Also
    --------
    build_operator : Assemble the operator of a mesh.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> mesh = sg.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> operator = sg.build_operator(mesh, "cotangent")
    >>> operator.stiffness.toarray()
    array([[ 1. , -0.5, -0.5],
           [-0.5,  0.5,  0. ],
           [-0.5,  0. ,  0.5]])
    >>> operator.lumped_mass.round(4).tolist()
    [0.1667, 0.1667, 0.1667]
    """

    stiffness: sparse.csc_array
    mass: sparse.csc_array
    vertex_areas: FloatArray | None = None
    boundary: NDArray[np.int64] | None = None

    @property
    def lumped_mass(self) -> FloatArray:
        """Area of each vertex, an (n,) array in squared mesh units."""
        if self.vertex_areas is not None:
            return self.vertex_areas
        return np.asarray(self.mass.sum(axis=1), dtype=np.float64).ravel()
