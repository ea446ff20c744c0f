# SPDX-License-Identifier: MIT
"""Fans: where surfaces touch in a single vertex, each of them gets a vertex of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.mesh.connectivity import shared_sides
from shapegoogle_core.mesh.mesh import IntArray, Mesh

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
    corners, count = mesh.faces.ravel(), len(mesh.vertices)
    one, other = shared_sides(mesh.faces, count)
    doubtful = _may_have_two_fans(corners, count, one, other)
    if not doubtful.any():
        return mesh
    chosen = np.flatnonzero(doubtful[corners])
    number = np.empty(len(corners), np.int32)
    number[chosen] = np.arange(len(chosen))
    # Each side of a face has a corner at its start and one at its end. Two sides run in the same direction or
    # in opposite ones.
    end_of_one, end_of_other = (side + 1 - 3 * (side % 3 == 2) for side in (one, other))
    same = corners[one] == corners[other]
    first = np.concatenate([one, end_of_one])
    second = np.concatenate([np.where(same, other, end_of_other), np.where(same, end_of_other, other)])
    linked = doubtful[corners[first]]
    links = number[first[linked]], number[second[linked]]
    graph = coo_array((np.ones(len(links[0]), np.int8), links), shape=(len(chosen),) * 2)
    fan_count, fan = connected_components(graph, directed=False)
    if fan_count == np.count_nonzero(doubtful):
        return mesh
    _, first_corner = np.unique(fan, return_index=True)
    vertex = corners[chosen[first_corner]]
    order = np.lexsort((first_corner, vertex))
    is_copy = np.zeros(fan_count, bool)
    is_copy[order[1:]] = vertex[order[1:]] == vertex[order[:-1]]
    place = vertex.copy()
    copies = np.flatnonzero(is_copy)
    copies = copies[np.argsort(first_corner[copies])]
    place[copies] = count + np.arange(len(copies))
    faces = corners.copy()
    faces[chosen] = place[fan]
    return Mesh(
        np.concatenate([mesh.vertices, mesh.vertices[vertex[copies]]]), faces.reshape(-1, 3), mesh.name
    )


def _may_have_two_fans(corners: IntArray, count: int, one: IntArray, other: IntArray) -> NDArray[np.bool_]:
    """Find the vertices around which the faces do not follow each other in a single cycle.

    Around the others, which are nearly all of most meshes, every edge is between two faces that run along it
    in opposite directions. Then each face is followed by another one, and the cycles can be found in much
    less time than the components of any graph.

    Parameters
    ----------
    corners : (3 m,) array of int
        Of all faces.
    count : int
        Number of vertices, all of which are used.
    one, other : (k,) arrays of int
        From `shared_sides`.

    Returns
    -------
    doubtful : (n,) array of bool
    """
    paired = corners[one] != corners[other]
    several = one[1:] == other[:-1]
    paired[1:] &= ~several
    paired[:-1] &= ~several
    one, other = one[paired], other[paired]
    partner = np.full(len(corners), -1, np.int32)
    partner[one], partner[other] = other, one
    # The side that ends in a corner comes before the one that starts there.
    following = partner.reshape(-1, 3)[:, [2, 0, 1]].ravel()
    last = np.flatnonzero(following < 0)
    following[last] = last
    # Label each corner with the least number in its cycle, twice as far along it in each round.
    itself = np.arange(len(corners), dtype=np.int32)
    label = itself
    while True:
        least = np.minimum(label, label[following])
        if np.array_equal(least, label):
            break
        label, following = least, following[following]
    doubtful: NDArray[np.bool_] = np.bincount(corners[label == itself], minlength=count) != 1
    doubtful[corners[last]] = True
    return doubtful
