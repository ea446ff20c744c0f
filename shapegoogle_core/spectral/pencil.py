# SPDX-License-Identifier: MIT
"""`Pencil`: the matrices of W φ = λ A φ, in the order and scale in which they are solved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.linalg.blas import dgemm

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Pairs", "Pencil", "prepare"]


@dataclass(frozen=True, eq=False)
class Pencil:
    """W and A in an order of small bandwidth; with a lumped mass A^-½ W A^-½, and no mass."""

    stiffness: sparse.csc_matrix
    mass: sparse.csc_matrix | None
    spacing: float  # mean distance of neighbouring eigenvalues by Weyl's law

    def weigh(self, block: FloatArray) -> FloatArray:
        """Multiply by A."""
        return block if self.mass is None else np.asfortranarray(self.mass @ block)

    def inner(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """Compute the inner products in A of the columns of one block with those of the other."""
        if not one.size:
            return np.empty((one.shape[1], other.shape[1]))
        # Faster than numpy's `one.T @ other` where the columns are few.
        return np.asarray(dgemm(1.0, one, self.weigh(other), trans_a=True))

    def shifted(self, shift: float) -> sparse.csc_matrix:
        """Form W - σA."""
        if self.mass is not None:
            return sparse.csc_matrix(self.stiffness - shift * self.mass)
        matrix = self.stiffness.copy()
        matrix.setdiag(matrix.diagonal() - shift)
        return matrix


@dataclass(frozen=True, eq=False)
class Pairs:
    """Ascending eigenvalues and their A-orthonormal eigenvectors."""

    values: FloatArray
    vectors: FloatArray

    def joined(self, other: Pairs) -> Pairs:
        """Return the union of two disjoint sets."""
        values = np.concatenate([self.values, other.values])
        vectors = np.hstack([self.vectors, other.vectors])
        ascending = np.argsort(values, kind="stable")
        if (np.diff(ascending) == 1).all():  # always, unless a second search was needed
            return Pairs(values, vectors)
        return Pairs(values[ascending], vectors[:, ascending])


def prepare(
    stiffness: sparse.csc_array, mass: sparse.csc_array, order: np.ndarray
) -> tuple[Pencil, FloatArray | None]:
    """Permute, and divide by a diagonal mass; the second value scales the eigenvectors back."""
    spacing = 4 * np.pi / mass.sum()
    # SuperLU finds its own ordering much faster on a matrix of small bandwidth.
    permuted = sparse.csc_matrix(stiffness[order][:, order])
    if mass.nnz > mass.shape[0]:
        return Pencil(permuted, sparse.csc_matrix(mass[order][:, order]), spacing), None
    scale = 1 / np.sqrt(mass.diagonal()[order])
    permuted.data *= scale[permuted.indices] * np.repeat(scale, np.diff(permuted.indptr))
    return Pencil(permuted, None, spacing), scale
