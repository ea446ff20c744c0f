# SPDX-License-Identifier: MIT
"""Block Lanczos on (W - σA)⁻¹A: eigenpairs on both sides of σ; see `eigensolver`."""

from __future__ import annotations

import numpy as np
from scipy.linalg.blas import dgemm

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.spectral.inertia import Factor
from shapegoogle_core.spectral.pencil import Pairs, Pencil

__all__ = ["block_lanczos"]

# Right-hand sides of one solve. More make faster products, but need a larger Krylov space.
BLOCK = 5
# Largest residual of a converged pair in B, as a share of |θ|. The error of its eigenvalue is of second
# order.
TOLERANCE = 1e-8


def block_lanczos(
    pencil: Pencil,
    factor: Factor,
    below: int,
    above: int,
    known: FloatArray,
    random: np.random.Generator,
    room: int = 1,
) -> tuple[Pairs, float]:
    """Find eigenpairs on both sides of the shift, orthogonal to those known.

    Parameters
    ----------
    pencil : Pencil
    factor : Factor
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
    pairs : Pairs
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
    return Pairs(factor.shift + 1 / thetas[wanted], vectors), float(following)


def _subtract_projection(pencil: Pencil, basis: FloatArray, block: FloatArray) -> FloatArray:
    """Make a block A-orthogonal to an A-orthonormal basis Q, in place, and return QᵀA times the block."""
    parts = pencil.inner(basis, block)
    if parts.size:
        # block -= basis @ parts, without a copy of that size
        dgemm(-1.0, basis, parts, beta=1.0, c=block, overwrite_c=1)
    return parts


def _orthonormalise(
    pencil: Pencil, basis: FloatArray, block: FloatArray, reference: float = 1.0
) -> FloatArray:
    """Make the columns of a block A-orthonormal in place, and return R of block = QR.

    By the eigenvectors of the Gram matrix, repeated until that is the identity (A. Stathopoulos, K. Wu: A
    Block Orthogonalization Procedure with Constant Synchronization Requirements, 2002). If the block has not
    full rank, the rest of it is rounding and becomes new directions, which are not coupled according to R.

    Parameters
    ----------
    pencil : Pencil
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
