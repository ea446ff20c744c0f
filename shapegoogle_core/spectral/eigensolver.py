# SPDX-License-Identifier: MIT
"""Smallest eigenpairs of a large sparse pencil (W, A), counted so that none is missed (paper, section 3.3).

Block Lanczos on the shift-inverted operator B = (W - σA)⁻¹A, whose eigenvalues are θ = 1/(λ - σ). With σ
inside the wanted range, the wanted θ are the outermost on both sides and converge in fewer steps than with a
shift below all of them. A factorisation W - μA = LDLᵀ has as many negative pivots as there are eigenvalues
below μ (Sylvester's law of inertia): counting them at σ and just above the last wanted eigenvalue proves that
the set is complete. Missing pairs are searched again, orthogonal to those found. For few pairs a
factorisation takes longer than some more steps, so σ lies just above the wanted range instead, and the one
count at σ is the proof.

References
----------
R. Grimes, J. Lewis, H. Simon: A Shifted Block Lanczos Algorithm for Solving Sparse Symmetric Generalized
Eigenproblems. SIAM Journal on Matrix Analysis and Applications 15(1), 1994.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral.block_lanczos import block_lanczos
from shapegoogle_core.spectral.inertia import CLUSTER, countable_gap, factor_inside, factorise
from shapegoogle_core.spectral.pencil import Pairs, Pencil, prepare

__all__ = ["smallest_pairs"]

# A dense cluster far from the shift takes more directions than other pairs: so many times the usual ones.
MOST_ROOM = 4


def smallest_pairs(
    stiffness: sparse.csc_array, mass: sparse.csc_array, k: int, constant: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Compute the k smallest solutions of W φ = λ A φ.

    Parameters
    ----------
    stiffness : (n, n) sparse array
        W, symmetric. Any will do; discrete Laplace operators of connected surfaces are fast.
    mass : (n, n) sparse array
        A, symmetric positive definite; its entries sum to the area. Diagonal or not.
    k : int
        Number of eigenpairs, at least 1 and at most n / 3.
    constant : bool
        Whether W maps the constant function to 0, and no eigenvalue is negative. The function is then
        returned exactly, and the others are orthogonal to it up to rounding. Otherwise no eigenvalue is
        assumed to be 0.

    Returns
    -------
    eigenvalues : (k,) array
        Ascending.
    eigenvectors : (n, k) array
        Orthonormal in A. The same input gives the same output, signs included.

    Raises
    ------
    ValueError
        If k is out of its range.
    numpy.linalg.LinAlgError
        If the pencil cannot be factorised, or the count of eigenvalues does not agree with those found.

    Notes
    -----
    Memory: about 2.5 k vectors of length n and two factorisations.
    """
    n = stiffness.shape[0]
    if not 1 <= k <= n // 3:
        raise ValueError(f"k must be between 1 and a third of the {n} unknowns, not {k}")
    order = reverse_cuthill_mckee(sparse.csr_matrix(stiffness), symmetric_mode=True)
    pencil, scale = prepare(stiffness, mass, order)
    known = Pairs(np.empty(0), np.empty((n, 0), order="F"))
    if constant:
        flat = np.ones(n) if scale is None else 1 / scale
        known = Pairs(np.zeros(1), np.asfortranarray(flat[:, None] / np.sqrt(mass.sum())))
    pairs = _complete_pairs(pencil, k, known)
    vectors = np.empty_like(pairs.vectors)
    place = np.argsort(order)
    # Column by column, as a column fits a cache.
    for target, vector in zip(vectors.T, pairs.vectors.T, strict=True):
        target[:] = (vector if scale is None else vector * scale)[place]
    return pairs.values, vectors


def _complete_pairs(pencil: Pencil, k: int, found: Pairs) -> Pairs:
    """Search for the pairs not found yet, count, and search again for those that are missing."""
    random = np.random.default_rng(0)
    factor = factor_inside(pencil, k, random)
    n = pencil.stiffness.shape[0]
    wanted = max(k, factor.below)
    following = np.inf  # least estimate of the eigenvalue after those found
    room = 1
    while True:
        found_below = int((found.values < factor.shift).sum())
        missing_below = max(factor.below - found_below, 0)
        missing_above = max(wanted - factor.below - (len(found.values) - found_below), 0)
        new, estimate = block_lanczos(
            pencil, factor, missing_below, missing_above, found.vectors, random, room
        )
        if missing_below + missing_above and not len(new.values) and room < MOST_ROOM:
            room *= 2
            continue
        if (missing_below + missing_above and not len(new.values)) or len(found.values) > n // 2:
            raise np.linalg.LinAlgError(f"found only {len(found.values)} of {wanted} eigenvalues")
        found = found.joined(new)
        if len(found.values) == factor.below >= k:
            return Pairs(found.values[:k], found.vectors[:, :k])
        following = min(
            (value for value in (following, estimate) if value > found.values[-1]), default=np.inf
        )
        if len(found.values) < wanted:
            continue
        bound, expected = countable_gap(found.values, following, k, CLUSTER * pencil.spacing)
        counted = factorise(pencil, bound, factor).below
        if counted < expected:
            raise np.linalg.LinAlgError(
                f"found {expected} eigenvalues below {bound:.6g}, but counted {counted}"
            )
        if counted == expected:
            return Pairs(found.values[:k], found.vectors[:, :k])
        wanted = len(found.values) + counted - expected
