# SPDX-License-Identifier: MIT
"""Surroundings of each vertex on the surface, and maxima in them."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.spatial import KDTree

from shapegoogle_core.mesh.connectivity import unique_edges
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["adjacency", "discs", "maxima_in"]

Indices = NDArray[np.int64]


def adjacency(mesh: Mesh) -> sparse.csr_array:
    """Join each vertex with itself and its neighbours along edges.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.

    Returns
    -------
    joined : (n, n) sparse array
        1 where two vertices are joined, and on the diagonal.
    """
    n = len(mesh.vertices)
    edges, _ = unique_edges(mesh)
    ends = np.concatenate([edges[:, 0], edges[:, 1], np.arange(n)])
    starts = np.concatenate([edges[:, 1], edges[:, 0], np.arange(n)])
    return sparse.csr_array((np.ones(len(ends), np.float32), (starts, ends)), shape=(n, n))


def discs(mesh: Mesh, radius: float, centers: Indices | None = None) -> sparse.csr_array:
    """Join vertices with those around them on the surface.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.
    radius : float
        Radius of the surroundings, in the unit of the mesh.
    centers : (c,) array of int, optional
        Vertices in the middle. Default: all.

    Returns
    -------
    joined : (c, n) sparse array
        1 for the vertex itself, for two rings of neighbours of any edge length, and for the vertices within
        the radius in space that are reached along edges within it, which excludes the other side of a thin
        sheet. The size of a row grows with the square of the radius, in edge lengths.
    """
    n = len(mesh.vertices)
    chosen = np.arange(n) if centers is None else centers
    joined = adjacency(mesh)
    itself = sparse.csr_array(
        (np.ones(len(chosen), np.float32), (range(len(chosen)), chosen)), (len(chosen), n)
    )
    near = KDTree(mesh.vertices[chosen]).sparse_distance_matrix(
        KDTree(mesh.vertices), radius, output_type="ndarray"
    )
    ball = itself + sparse.csr_array((np.ones(len(near), np.float32), (near["i"], near["j"])), itself.shape)
    ball.data[:] = 1
    reached = itself
    while True:
        further = sparse.csr_array(ball.multiply(reached @ joined))
        further.data[:] = 1
        if further.nnz == reached.nnz:
            break
        reached = further
    whole = sparse.csr_array(itself @ joined @ joined + reached)
    whole.data[:] = 1
    return whole


def maxima_in(
    values: FloatArray, joined: sparse.csr_array, centers: Indices | None = None
) -> NDArray[np.bool_]:
    """Find the vertices that have the largest value among those they are joined with.

    Parameters
    ----------
    values : (n,) array
        Value of each vertex. Of equal values the one with the smaller index counts as larger.
    joined : (c, n) sparse array
        From `adjacency` or `discs`; every row joins a vertex with itself.
    centers : (c,) array of int, optional
        Vertices of the rows. Default: all.

    Returns
    -------
    largest : (n,) array of bool
        Mask of these vertices; False at vertices that are not centres.
    """
    n = len(values)
    rank = np.empty(n, np.int64)
    rank[np.lexsort((np.arange(n), -values))] = np.arange(n)
    chosen = np.arange(n) if centers is None else centers
    largest = np.zeros(n, bool)
    if len(chosen):
        largest[chosen] = np.minimum.reduceat(rank[joined.indices], joined.indptr[:-1]) == rank[chosen]
    return largest
