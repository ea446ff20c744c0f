# SPDX-License-Identifier: MIT
"""Fans: where surfaces touch in a single vertex, each of them gets a vertex of its own."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.mesh.mesh import Mesh

__all__ = ["separate_fans"]


def separate_fans(mesh: Mesh) -> Mesh:
    """Give each fan of faces around a vertex a vertex of its own.

    A fan consists of faces around a vertex that are connected by edges. Heat cannot cross a point of a
    surface, but it crosses a vertex of a mesh, the more the larger its faces are. So an eye that is welded to
    its socket in two places is a part of its own, at every resolution.

    Parameters
    ----------
    mesh : Mesh
        Repaired.

    Returns
    -------
    separated : Mesh
        The same vertices and faces first, then copies of vertices. The mesh itself if no vertex has two fans.

    Examples
    --------
    >>> from shapegoogle_core.mesh import Mesh
    >>> from shapegoogle_core.preprocessing import separate_fans
    >>> bow_tie = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], [[0, 1, 2], [0, 3, 4]])
    >>> separate_fans(bow_tie)
    Mesh('mesh', 6 vertices, 2 faces)
    """
    corners = mesh.faces.ravel().astype(np.int64)
    count = len(mesh.vertices)
    # Each side of a face has a corner at its start and one at its end.
    start = np.arange(len(corners))
    end = start.reshape(-1, 3)[:, [1, 2, 0]].ravel()
    turned = corners[start] > corners[end]
    low, high = np.where(turned, end, start), np.where(turned, start, end)
    key = corners[low] * count + corners[high]
    order = np.argsort(key)
    shared = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    one, other = order[shared], order[shared + 1]
    row, column = np.concatenate([low[one], high[one]]), np.concatenate([low[other], high[other]])
    graph = coo_array((np.ones(len(row), np.int8), (row, column)), shape=(len(corners),) * 2)
    fan_count, fan = connected_components(graph, directed=False)
    if fan_count == count:
        return mesh
    _, first_corner = np.unique(fan, return_index=True)
    vertex = corners[first_corner]
    order = np.lexsort((first_corner, vertex))
    is_copy = np.zeros(fan_count, bool)
    is_copy[order[1:]] = vertex[order[1:]] == vertex[order[:-1]]
    place = vertex.copy()
    copies = np.flatnonzero(is_copy)
    copies = copies[np.argsort(first_corner[copies])]
    place[copies] = count + np.arange(len(copies))
    return Mesh(
        np.concatenate([mesh.vertices, mesh.vertices[vertex[copies]]]), place[fan].reshape(-1, 3), mesh.name
    )
