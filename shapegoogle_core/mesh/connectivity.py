# SPDX-License-Identifier: MIT
"""Edges, boundaries and used vertices of a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

if TYPE_CHECKING:
    from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh

__all__ = [
    "any_corner",
    "boundary_vertices",
    "edge_graph",
    "edge_lengths",
    "shared_sides",
    "sorted_pairs",
    "unique_edges",
    "used_points",
    "used_vertices",
]

# So few pairs are sorted by comparison before sparse matrices are made.
_FEW = 1 << 13


def unique_edges(mesh: Mesh) -> tuple[IntArray, NDArray[np.int64]]:
    """Find the undirected edges and the number of faces at each.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    edges : (e, 2) array of int32
        Each edge once, smaller vertex first, sorted.
    face_counts : (e,) array of int
        1 on an open boundary, 2 inside a manifold surface, more on a non-manifold edge.
    """
    count = len(mesh.vertices)
    start, end = mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()
    ends = np.minimum(start, end), np.maximum(start, end)
    # A sparse matrix sorts its rows by counting, which is faster than sorting the edges.
    faces_at = coo_array((np.ones(len(start), np.int32), ends), shape=(count, count)).tocsr()
    faces_at.sort_indices()
    first = np.repeat(np.arange(count, dtype=np.int32), np.diff(faces_at.indptr))
    return np.stack([first, faces_at.indices], axis=1), faces_at.data.astype(np.int64)


def edge_lengths(mesh: Mesh) -> FloatArray:
    """Length of each edge, in the order of `unique_edges`.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    lengths : (e,) array
    """
    start, end = unique_edges(mesh)[0].T
    return np.asarray(np.linalg.norm(mesh.vertices[start] - mesh.vertices[end], axis=1))


def edge_graph(mesh: Mesh) -> csr_array:
    """Build the graph of the edges, for shortest paths along them in either direction.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    lengths : (n, n) sparse array
        Each edge once, in the unit of the vertices.
    """
    return csr_array((edge_lengths(mesh), unique_edges(mesh)[0].T), shape=(len(mesh.vertices),) * 2)


def boundary_vertices(mesh: Mesh) -> NDArray[np.bool_]:
    """Find the vertices on open boundaries.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    mask : (n,) array of bool
    """
    edges, face_counts = unique_edges(mesh)
    mask = np.zeros(len(mesh.vertices), bool)
    mask[edges[face_counts == 1]] = True
    return mask


def used_vertices(faces: NDArray[np.integer], count: int) -> tuple[NDArray[np.int64], NDArray[np.integer]]:
    """Find the vertices that faces use, and renumber the faces: ``numpy.unique`` without sorting.

    Parameters
    ----------
    faces : (m, 3) array of int
    count : int
        Number of vertices.

    Returns
    -------
    used : (u,) array of int
        Ascending.
    renumbered : (m, 3) array of int
        ``used[renumbered]`` is `faces`.
    """
    is_used = np.zeros(count, bool)
    is_used[faces] = True
    used = np.flatnonzero(is_used)
    if len(used) == count:
        return used, faces
    return used, (np.cumsum(is_used) - 1)[faces]


def any_corner(marked: NDArray[np.bool_], rows: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Find the faces or edges of which any vertex is marked.

    Parameters
    ----------
    marked : (n,) array of bool
    rows : (m, 3) or (m, 2) array of int
        Vertices of each.

    Returns
    -------
    found : (m,) array of bool
        ``marked[rows].any(axis=1)``, in a fifth of the time.
    """
    return np.asarray(marked.take(rows.T).any(axis=0))


def used_points(vertices: FloatArray, faces: NDArray[np.integer]) -> FloatArray:
    """Return the positions of the vertices that faces use.

    Parameters
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array of int
        No rows for a point cloud, of which all points are used.

    Returns
    -------
    points : (u, 3) array
        The vertices themselves if all are used.
    """
    if len(faces) == 0:
        return vertices
    is_used = np.zeros(len(vertices), bool)
    is_used[faces] = True
    return vertices if is_used.all() else vertices[is_used]


def sorted_pairs(first: IntArray, second: IntArray, count: int) -> NDArray[np.int32]:
    """Sort pairs of vertices by counting, in linear time: ``numpy.lexsort((second, first))``.

    Parameters
    ----------
    first, second : (n,) arrays of int32
    count : int
        Number of vertices.

    Returns
    -------
    order : (n,) array of int32
        Equal pairs keep their order.
    """
    if len(first) < _FEW:
        return np.argsort(first.astype(np.int64) * count + second, kind="stable").astype(np.int32)
    # A sparse matrix with one entry per row sorts these when it is turned into columns.
    starts = np.arange(len(first) + 1, dtype=np.int32)
    shape = len(first), count
    by_second = csr_array((first, second, starts), shape=shape).tocsc()
    by_both = csr_array((by_second.indices, by_second.data, starts), shape=shape).tocsc()
    return np.asarray(by_both.data, np.int32)


def shared_sides(corners: NDArray[np.integer], count: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Find the sides of faces that lie on the same edge.

    Parameters
    ----------
    corners : (m, 3) array of int
        Of each face. Side 3f + c goes from corner c of face f to the next one.
    count : int
        Number of vertices.

    Returns
    -------
    one, other : (k,) arrays of int32
        Of an edge with j faces j - 1 pairs of sides, each with the next one in order, sorted by edge.
    """
    start = corners.astype(np.int32)
    end = start[:, [1, 2, 0]].ravel()
    start = start.ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = sorted_pairs(low, high, count)
    low, high = low[order], high[order]
    same = np.flatnonzero((low[1:] == low[:-1]) & (high[1:] == high[:-1]))
    return order[same], order[same + 1]
