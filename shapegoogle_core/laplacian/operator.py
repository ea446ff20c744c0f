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
        W, symmetric positive semi-definite, rows sum to 0, no unit. The first n of the d degrees of freedom
        are values at the mesh's vertices; most operators have no others.
    mass : (d, d) sparse array
        A, symmetric positive definite, squared mesh units, sums to the area. Diagonal when lumped.
    vertex_areas : (n,) array or None
        Area of each vertex in squared mesh units. None: d = n, and these are the row sums of `mass`.
    boundary : (b,) array of int or None
        Degrees of freedom on the open boundary. None: it is not known.
    """

    stiffness: sparse.csc_array
    mass: sparse.csc_array
    vertex_areas: FloatArray | None = None
    boundary: NDArray[np.int64] | None = None

    @property
    def lumped_mass(self) -> FloatArray:
        """(n,) area of each vertex in squared mesh units."""
        if self.vertex_areas is not None:
            return self.vertex_areas
        return np.asarray(self.mass.sum(axis=1), dtype=np.float64).ravel()
