# SPDX-License-Identifier: MIT
"""Diagonal of the inverse of a sparse matrix, without computing the rest of the inverse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse.csgraph import breadth_first_order, connected_components

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["Levels", "inverse_diagonal", "level_structure"]

# Least number of vertices of a block; levels are joined up to it, as calls dominate the cost of smaller ones.
LEAST_BLOCK = 48


@dataclass(frozen=True, eq=False)
class Levels:
    """An order in which a sparse symmetric matrix is block tridiagonal.

    Attributes
    ----------
    order : (n,) array of int
        Vertex at each place of the new order.
    bounds : (b + 1,) array of int
        Start of each block, and n. Entries join only places of the same block or of neighbouring blocks.
    """

    order: NDArray[np.int64]
    bounds: NDArray[np.int64]


def level_structure(pattern: sparse.csr_array) -> Levels:
    """Order a symmetric matrix by the number of edges to a vertex at the periphery.

    An edge joins vertices of the same level or of neighbouring levels. On a surface of n vertices the levels
    are rings of some √n vertices.

    Parameters
    ----------
    pattern : (n, n) sparse array
        Symmetric; each entry is an edge, whatever its value.

    Returns
    -------
    levels : Levels
        The components follow one after another.
    """
    graph = sparse.csr_array((np.ones(pattern.nnz), pattern.indices, pattern.indptr), shape=pattern.shape)
    _, component = connected_components(graph, directed=False)
    members = np.split(np.argsort(component, kind="stable"), np.cumsum(np.bincount(component))[:-1])
    orders: list[NDArray[np.int64]] = []
    sizes: list[int] = []
    for vertices in members:
        if len(vertices) <= LEAST_BLOCK:
            orders.append(vertices)
            sizes.append(len(vertices))
            continue
        first = vertices[0]
        # The vertex found last lies at the periphery, from where there are more and smaller levels.
        for _ in range(2):
            first = breadth_first_order(graph, first, return_predecessors=False)[-1]
        order, parent = breadth_first_order(graph, first)
        orders.append(order.astype(np.int64))
        sizes.extend(np.bincount(_depths(order, parent)).tolist())
    bounds = [0]
    ends = np.cumsum(sizes).tolist()
    for end in ends:
        if end - bounds[-1] >= LEAST_BLOCK or end == ends[-1]:
            bounds.append(end)
    return Levels(np.concatenate(orders), np.array(bounds))


def _depths(order: NDArray[np.int32], parent: NDArray[np.int32]) -> NDArray[np.int64]:
    """Compute the level of each vertex of a breadth-first order, ascending from 0."""
    place = np.zeros(len(parent), np.int64)
    place[order] = np.arange(len(order))
    parent_place = place[parent[order[1:]]].tolist()
    depths = [0]
    for above in parent_place:
        depths.append(depths[above] + 1)
    return np.array(depths)


def inverse_diagonal(matrix: sparse.csr_array, levels: Levels) -> FloatArray:
    """Compute the diagonal of the inverse of a sparse positive definite matrix, exactly.

    With blocks D_i on the diagonal and C_i to the right of them, elimination from the first block to the last
    gives S_i = D_i - C_{i-1}ᵀ S_{i-1}⁻¹ C_{i-1}. From the last to the first, the diagonal blocks of the
    inverse are G_i = S_i⁻¹ + S_i⁻¹ C_i G_{i+1} C_iᵀ S_i⁻¹ (Takahashi, Fagan, Chin 1973, by blocks).

    Parameters
    ----------
    matrix : (n, n) sparse array
        Symmetric positive definite.
    levels : Levels
        Order of the pattern of the matrix, from `level_structure`.

    Returns
    -------
    diagonal : (n,) array

    Raises
    ------
    numpy.linalg.LinAlgError
        If the matrix is not positive definite.

    Notes
    -----
    Blocks of width w take some 6 n w² operations and n w numbers of memory; on a surface w ~ √n.
    """
    ordered = matrix[levels.order][:, levels.order]
    count = len(levels.bounds) - 1
    parts = [slice(start, end) for start, end in zip(levels.bounds[:-1], levels.bounds[1:], strict=True)]
    right = [ordered[parts[i], parts[i + 1]] for i in range(count - 1)]
    inverses: list[FloatArray] = []
    for i in range(count):
        block = ordered[parts[i], parts[i]].toarray()
        if i > 0:
            block -= right[i - 1].T @ (inverses[-1] @ right[i - 1])
        inverses.append(_inverse(block))
    diagonal = np.empty(len(levels.order))
    inverse = inverses[-1]
    diagonal[levels.order[parts[-1]]] = np.diag(inverse)
    for i in reversed(range(count - 1)):
        carried = inverses[i] @ right[i]
        inverse = inverses[i] + carried @ (inverse @ carried.T)
        diagonal[levels.order[parts[i]]] = np.diag(inverse)
    return diagonal


def _inverse(block: FloatArray) -> FloatArray:
    """Invert a dense positive definite matrix by its Cholesky factor."""
    factor, failed = lapack.dpotrf(block)
    if failed:
        raise np.linalg.LinAlgError("the matrix is not positive definite")
    upper = np.triu(lapack.dpotri(factor)[0])
    return np.asarray(upper + np.triu(upper, 1).T)
