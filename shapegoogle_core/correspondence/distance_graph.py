# SPDX-License-Identifier: MIT
"""Approximate distances along a surface: a graph of its edges and of shortcuts across them."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["distance_graph"]

Indices = NDArray[np.int64]


def distance_graph(mesh: Mesh, ties: Indices, tie_lengths: FloatArray) -> sparse.csr_array:
    """Connect vertices by edges, by ties, and by shortcuts across every edge.

    A shortcut joins the two corners opposite to an edge. Paths along edges alone zigzag and are about a tenth
    too long.

    Parameters
    ----------
    mesh : Mesh
    ties : (t, 2) array of int
        Pairs of vertices that join loose parts.
    tie_lengths : (t,) array

    Returns
    -------
    graph : (n, n) sparse array
        Length of each connection between the n vertices.
    """
    n = len(mesh.vertices)
    sides = mesh.faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2).astype(np.int64)
    opposite = mesh.faces.ravel().astype(np.int64)
    keys = sides.min(axis=1) * n + sides.max(axis=1)
    order = np.argsort(keys, kind="stable")
    twin = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    one, other = order[twin], order[twin + 1]
    across = np.stack([opposite[one], opposite[other]], axis=1)
    a, b = mesh.vertices[sides[one, 0]], mesh.vertices[sides[one, 1]]
    across_lengths = _unfolded(a, b, mesh.vertices[across[:, 0]], mesh.vertices[across[:, 1]])
    edge_lengths = np.linalg.norm(mesh.vertices[sides[:, 0]] - mesh.vertices[sides[:, 1]], axis=1)
    pairs = np.concatenate([sides, across, ties])
    lengths = np.concatenate([edge_lengths, across_lengths, tie_lengths])
    # Of several connections between two vertices the shortest one counts; a sparse array would add them up.
    pairs, lengths = pairs[np.isfinite(lengths)], lengths[np.isfinite(lengths)]
    keys = pairs.min(axis=1) * n + pairs.max(axis=1)
    order = np.lexsort([lengths, keys])
    keys, first = np.unique(keys[order], return_index=True)
    lengths = np.maximum(lengths[order[first]], 1e-12)  # no entry of the graph may be 0
    start, end = np.divmod(keys, n)
    return sparse.csr_array(sparse.coo_array((lengths, (start, end)), shape=(n, n)))


def _unfolded(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Return the distance of c and d across the unfolded faces abc and bad, infinite if it leaves them."""
    side = b - a
    length = np.linalg.norm(side, axis=1)
    direction = side / np.maximum(length, np.finfo(float).tiny)[:, None]
    along = [((point - a) * direction).sum(axis=1) for point in (c, d)]
    height = [
        np.linalg.norm(point - a - x[:, None] * direction, axis=1)
        for point, x in zip((c, d), along, strict=True)
    ]
    total = np.maximum(height[0] + height[1], np.finfo(float).tiny)
    crossing = (along[0] * height[1] + along[1] * height[0]) / total
    inside = (crossing >= 0) & (crossing <= length)
    distance: FloatArray = np.where(inside, np.hypot(along[0] - along[1], height[0] + height[1]), np.inf)
    return distance
