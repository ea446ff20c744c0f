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

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.linalg.blas import dgemm
from scipy.sparse.csgraph import reverse_cuthill_mckee
from scipy.sparse.linalg import SuperLU, splu

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["smallest_pairs"]

# Right-hand sides of one solve. More make faster products, but need a larger Krylov space.
BLOCK = 5
# Largest residual of a converged pair in B, as a share of |θ|. The error of its eigenvalue is of second
# order.
TOLERANCE = 1e-8
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
# A dense cluster far from the shift takes more directions than other pairs: so many times the usual ones.
MOST_ROOM = 4


@dataclass(frozen=True, eq=False)
class _Pencil:
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
class _Factor:
    """Factorisation of W - σA."""

    shift: float
    lu: SuperLU
    below: int  # number of eigenvalues below the shift


@dataclass(frozen=True, eq=False)
class _Pairs:
    """Ascending eigenvalues and their A-orthonormal eigenvectors."""

    values: FloatArray
    vectors: FloatArray

    def joined(self, other: _Pairs) -> _Pairs:
        """Return the union of two disjoint sets."""
        values = np.concatenate([self.values, other.values])
        vectors = np.hstack([self.vectors, other.vectors])
        ascending = np.argsort(values, kind="stable")
        if (np.diff(ascending) == 1).all():  # always, unless a second search was needed
            return _Pairs(values, vectors)
        return _Pairs(values[ascending], vectors[:, ascending])


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
    pencil, scale = _prepare(stiffness, mass, order)
    known = _Pairs(np.empty(0), np.empty((n, 0), order="F"))
    if constant:
        flat = np.ones(n) if scale is None else 1 / scale
        known = _Pairs(np.zeros(1), np.asfortranarray(flat[:, None] / np.sqrt(mass.sum())))
    pairs = _complete_pairs(pencil, k, known)
    vectors = np.empty_like(pairs.vectors)
    place = np.argsort(order)
    # Column by column, as a column fits a cache.
    for target, vector in zip(vectors.T, pairs.vectors.T, strict=True):
        target[:] = (vector if scale is None else vector * scale)[place]
    return pairs.values, vectors


def _prepare(
    stiffness: sparse.csc_array, mass: sparse.csc_array, order: np.ndarray
) -> tuple[_Pencil, FloatArray | None]:
    """Permute, and divide by a diagonal mass; the second value scales the eigenvectors back."""
    spacing = 4 * np.pi / mass.sum()
    # SuperLU finds its own ordering much faster on a matrix of small bandwidth.
    permuted = sparse.csc_matrix(stiffness[order][:, order])
    if mass.nnz > mass.shape[0]:
        return _Pencil(permuted, sparse.csc_matrix(mass[order][:, order]), spacing), None
    scale = 1 / np.sqrt(mass.diagonal()[order])
    permuted.data *= scale[permuted.indices] * np.repeat(scale, np.diff(permuted.indptr))
    return _Pencil(permuted, None, spacing), scale


def _complete_pairs(pencil: _Pencil, k: int, found: _Pairs) -> _Pairs:
    """Search for the pairs not found yet, count, and search again for those that are missing."""
    random = np.random.default_rng(0)
    factor = _factor_inside(pencil, k, random)
    n = pencil.stiffness.shape[0]
    wanted = max(k, factor.below)
    following = np.inf  # least estimate of the eigenvalue after those found
    room = 1
    while True:
        found_below = int((found.values < factor.shift).sum())
        missing_below = max(factor.below - found_below, 0)
        missing_above = max(wanted - factor.below - (len(found.values) - found_below), 0)
        new, estimate = _block_lanczos(
            pencil, factor, missing_below, missing_above, found.vectors, random, room
        )
        if missing_below + missing_above and not len(new.values) and room < MOST_ROOM:
            room *= 2
            continue
        if (missing_below + missing_above and not len(new.values)) or len(found.values) > n // 2:
            raise np.linalg.LinAlgError(f"found only {len(found.values)} of {wanted} eigenvalues")
        found = found.joined(new)
        if len(found.values) == factor.below >= k:
            return _Pairs(found.values[:k], found.vectors[:, :k])
        following = min(
            (value for value in (following, estimate) if value > found.values[-1]), default=np.inf
        )
        if len(found.values) < wanted:
            continue
        bound, expected = _gap(found.values, following, k, CLUSTER * pencil.spacing)
        counted = _factorise(pencil, bound, factor).below
        if counted < expected:
            raise np.linalg.LinAlgError(
                f"found {expected} eigenvalues below {bound:.6g}, but counted {counted}"
            )
        if counted == expected:
            return _Pairs(found.values[:k], found.vectors[:, :k])
        wanted = len(found.values) + counted - expected


def _gap(values: FloatArray, following: float, k: int, rounding: float) -> tuple[float, int]:
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


def _factorise(pencil: _Pencil, shift: float, earlier: _Factor | None = None) -> _Factor:
    """Factorise W - σA without exchanging rows, which keeps the pivots' signs those of D in LDLᵀ.

    Parameters
    ----------
    pencil : _Pencil
    shift : float
        σ.
    earlier : _Factor, optional
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
    return _Factor(shift, lu, int((lu.U.diagonal() < 0).sum()))


def _factor_inside(pencil: _Pencil, k: int, random: np.random.Generator) -> _Factor:
    """Factorise at a shift inside the k smallest eigenvalues, or just above them if they are few.

    If none suits, the shift lies below all eigenvalues.
    """
    inside = LEAST_BELOW * k, SHARE_BELOW * k, MOST_BELOW * k
    above = float(k), float(k + SPARE), float(k + MOST_SPARE)
    least, aim, most = above if k <= FEW_PAIRS else inside
    shift = aim * pencil.spacing
    for _ in range(5):
        try:
            factor = _factorise(pencil, shift)
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
    return _factorise(pencil, -0.05 * pencil.spacing)


def _is_accurate(pencil: _Pencil, factor: _Factor, random: np.random.Generator) -> bool:
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


def _block_lanczos(
    pencil: _Pencil,
    factor: _Factor,
    below: int,
    above: int,
    known: FloatArray,
    random: np.random.Generator,
    room: int = 1,
) -> tuple[_Pairs, float]:
    """Find eigenpairs on both sides of the shift, orthogonal to those known.

    Parameters
    ----------
    pencil : _Pencil
    factor : _Factor
        Of W - σA.
    below, above : int
        Numbers of pairs to find on each side of σ: all below it, the nearest above it.
    known : (n, p) array
        A-orthonormal eigenvectors to which the new ones are orthogonal.
    random : numpy.random.Generator
        Source of the first block.
    room : int, optional
        Size of the Krylov space, in multiples of the usual one.

    Returns
    -------
    pairs : _Pairs
        The pairs that converged before the Krylov space was full: nearly always all of them.
    following : float
        Estimate of the next eigenvalue above the last one; ∞ if there is none yet.
    """
    n, locked = known.shape
    capacity = min(n - locked - BLOCK, room * (3 * (below + above) + 30 * BLOCK))
    basis = np.empty((n, locked + capacity + BLOCK), order="F")
    basis[:, :locked] = known
    start = basis[:, locked : locked + BLOCK]
    start[:] = random.standard_normal(start.shape)
    _subtract_projection(pencil, basis[:, :locked], start)
    _orthonormalise(pencil, basis[:, :locked], start)
    projected = np.zeros((capacity + BLOCK, capacity + BLOCK))  # B in the basis: block tridiagonal
    size = BLOCK
    is_orthogonal = True  # the newest block to the whole basis
    check_at = 1.7 * (below + above)  # none converges before
    while True:
        block = slice(size - BLOCK, size)
        remainder = basis[:, locked + size : locked + size + BLOCK]
        remainder[:] = factor.lu.solve(pencil.weigh(basis[:, locked + size - BLOCK : locked + size]))
        recent = slice(max(0, size - 2 * BLOCK), size)
        parts = _subtract_projection(pencil, basis[:, locked + recent.start : locked + size], remainder)
        projected[recent, block] = parts
        projected[block, recent] = parts.T
        # The recurrence alone leaves about 1e-12 of the earlier blocks, and a thousand times more with each
        # further step: max |θ| / ‖coupling‖. So every other block can wait, and one pass over the basis
        # serves two.
        is_orthogonal = not is_orthogonal
        if is_orthogonal:
            last_two = basis[:, locked + size - BLOCK : locked + size + BLOCK]
            _subtract_projection(pencil, basis[:, : locked + size - BLOCK], last_two)
            _subtract_projection(pencil, last_two[:, :BLOCK], remainder)
        coupling = _orthonormalise(pencil, basis[:, : locked + size], remainder, float(np.abs(parts).max()))
        full = size + 2 * BLOCK > capacity
        if is_orthogonal and (size >= check_at or full):
            thetas, directions = np.linalg.eigh(projected[:size, :size])
            residuals = np.linalg.norm(coupling @ directions[block], axis=0)
            wanted = np.r_[0:below, size - above : size]
            is_on_its_side = np.r_[thetas[:below] < 0, thetas[size - above :] > 0]
            excess = np.where(
                is_on_its_side, residuals[wanted] / (TOLERANCE * np.abs(thetas[wanted])), np.inf
            )
            if full or excess.max(initial=0.0) <= 1:
                break
            # A block gains about one digit at best: check again after as many as are needed.
            check_at = size + BLOCK * np.ceil(np.log10(min(excess.max(), 1e8)))
        size += BLOCK
    wanted = wanted[excess <= 1]
    wanted = wanted[np.argsort(factor.shift + 1 / thetas[wanted])]
    # Bx/θ instead of x: a step of inverse iteration that costs no solve. It removes the rough part of the
    # error, which W would amplify.
    steps = np.concatenate([directions[:, wanted], coupling @ directions[block, wanted] / thetas[wanted]])
    vectors = np.asarray(dgemm(1.0, basis[:, locked : locked + size + BLOCK], steps))
    has_next = size - above - 1 >= below and thetas[size - above - 1] > 0
    following = factor.shift + 1 / thetas[size - above - 1] if has_next else np.inf
    return _Pairs(factor.shift + 1 / thetas[wanted], vectors), float(following)


def _subtract_projection(pencil: _Pencil, basis: FloatArray, block: FloatArray) -> FloatArray:
    """Make a block A-orthogonal to an A-orthonormal basis Q, in place, and return QᵀA times the block."""
    parts = pencil.inner(basis, block)
    if parts.size:
        # block -= basis @ parts, without a copy of that size
        dgemm(-1.0, basis, parts, beta=1.0, c=block, overwrite_c=1)
    return parts


def _orthonormalise(
    pencil: _Pencil, basis: FloatArray, block: FloatArray, reference: float = 1.0
) -> FloatArray:
    """Make the columns of a block A-orthonormal in place, and return R of block = QR.

    By the eigenvectors of the Gram matrix, repeated until that is the identity (A. Stathopoulos, K. Wu: A
    Block Orthogonalization Procedure with Constant Synchronization Requirements, 2002). If the block has not
    full rank, the rest of it is rounding and becomes new directions, which are not coupled according to R.

    Parameters
    ----------
    pencil : _Pencil
    basis : (n, m) array
        A-orthonormal basis to which the block is orthogonal, and stays so.
    block : (n, b) array
        Columns to change.
    reference : float
        Norm in A of the block before the projection on the basis was subtracted.

    Returns
    -------
    coupling : (b, b) array
        R.
    """
    coupling = np.eye(block.shape[1])
    for _ in range(8):
        gram = pencil.inner(block, block)
        if np.abs(gram - np.eye(len(gram))).max() < 1e-13:
            return coupling
        norms = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
        variances, directions = np.linalg.eigh(gram / np.outer(norms, norms))
        spreads = np.sqrt(np.maximum(variances, np.finfo(float).eps * len(gram)))
        block[:] = dgemm(1.0, block, directions / norms[:, None] / spreads)
        coupling = (spreads[:, None] * directions.T * norms) @ coupling
        if variances[0] < 1e-4 or norms.min() < 1e-8 * reference:
            _subtract_projection(pencil, basis, block)
        reference = 0.0
    raise np.linalg.LinAlgError("the Krylov space cannot be extended")
