# SPDX-License-Identifier: MIT
"""What lies around each vertex: discs on the surface, normals, and maxima among neighbours."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.spatial import KDTree

from shapegoogle_core.mesh.mesh import FloatArray, Mesh, unique_edges

__all__ = ["adjacency", "boundary_vertices", "discs", "maxima_in", "vertex_normals"]


def adjacency(mesh: Mesh) -> sparse.csr_array:
    """Join each vertex with itself and its neighbours along edges.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    joined : (n, n) sparse array
        1 where two vertices are joined.
    """
    n = len(mesh.vertices)
    edges, _ = unique_edges(mesh)
    ends = np.concatenate([edges[:, 0], edges[:, 1], np.arange(n)])
    starts = np.concatenate([edges[:, 1], edges[:, 0], np.arange(n)])
    return sparse.csr_array((np.ones(len(ends), np.float32), (starts, ends)), shape=(n, n))


def discs(mesh: Mesh, radius: float) -> sparse.csr_array:
    """Join each vertex with those around it on the surface.

    Parameters
    ----------
    mesh : Mesh
    radius : float
        In the unit of the mesh.

    Returns
    -------
    joined : (n, n) sparse array
        1 for the vertex itself, for two rings of neighbours however long their edges are, and for what is
        within the radius in space and reached along edges within it: the other side of a thin sheet is not.
        Rows grow with the square of the radius, in edge lengths.
    """
    n = len(mesh.vertices)
    joined = adjacency(mesh)
    two_rings = joined @ joined
    pairs = KDTree(mesh.vertices).query_pairs(radius, output_type="ndarray")
    ends = np.concatenate([pairs[:, 0], pairs[:, 1], np.arange(n)])
    starts = np.concatenate([pairs[:, 1], pairs[:, 0], np.arange(n)])
    ball = sparse.csr_array((np.ones(len(ends), np.float32), (starts, ends)), shape=(n, n))
    reached = sparse.csr_array(sparse.eye_array(n, dtype=np.float32))
    while True:
        further = ball.multiply(reached @ joined).tocsr()
        if further.nnz == reached.nnz:
            break
        reached = further
        reached.data[:] = 1
    whole = sparse.csr_array(two_rings + reached)
    whole.data[:] = 1
    return whole


def maxima_in(values: FloatArray, joined: sparse.csr_array) -> NDArray[np.bool_]:
    """Mask of the vertices that have the largest value among those they are joined with.

    Parameters
    ----------
    values : (n,) array
        Of equal values the one with the smaller index counts as larger.
    joined : (n, n) sparse array
        From `adjacency` or `discs`; every row joins a vertex with itself.

    Returns
    -------
    largest : (n,) array of bool
    """
    n = len(values)
    rank = np.empty(n, np.int64)
    rank[np.lexsort((np.arange(n), -values))] = np.arange(n)
    largest: NDArray[np.bool_] = np.minimum.reduceat(rank[joined.indices], joined.indptr[:-1]) == rank
    return largest


def boundary_vertices(mesh: Mesh) -> NDArray[np.bool_]:
    """Mask of the vertices on open boundaries."""
    edges, face_counts = unique_edges(mesh)
    mask = np.zeros(len(mesh.vertices), bool)
    mask[edges[face_counts == 1]] = True
    return mask


def vertex_normals(mesh: Mesh) -> FloatArray:
    """(n, 3) unit normals, weighted by the areas of faces; 0 where faces cancel out."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    weighted = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    corners = mesh.faces.ravel()
    n = len(mesh.vertices)
    summed = np.stack([np.bincount(corners, weighted[:, axis], n) for axis in range(3)], axis=1)
    lengths = np.linalg.norm(summed, axis=1, keepdims=True)
    normals: FloatArray = np.divide(summed, lengths, out=np.zeros_like(summed), where=lengths > 0)
    return normals
