# SPDX-License-Identifier: MIT
"""Prolongation: values at the vertices of a preprocessed mesh, interpolated at those of the original."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import KDTree

from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["nearest_faces", "prolongation", "vertex_prolongation"]

# The nearest point of a surface lies in a face at one of this many nearest vertices if faces are even.
NEAREST_VERTICES = 3
POINTS_AT_ONCE = 20_000  # each has some twenty faces to compare


def prolongation(mesh: Mesh, points: FloatArray) -> csr_array:
    """Linear interpolation from the vertices of a mesh to points on or close to it.

    Every point takes the value at the nearest point of the surface, among the faces at its three nearest
    vertices. Where two sheets lie closer to each other than the vertices of the mesh do, it may be the other
    sheet's.

    Parameters
    ----------
    mesh : Mesh
        Every vertex must belong to a face.
    points : (p, 3) array

    Returns
    -------
    matrix : (p, n) sparse array
        Barycentric weights: rows are ≥ 0 and sum to 1. ``matrix @ values`` carries values over.
    """
    face, weights = nearest_faces(mesh, points)
    rows = np.arange(3 * len(points) + 1, step=3)
    return csr_array(
        (weights.ravel(), mesh.faces[face].ravel(), rows), shape=(len(points), len(mesh.vertices))
    )


def nearest_faces(mesh: Mesh, points: FloatArray) -> tuple[NDArray[np.int64], FloatArray]:
    """Find the nearest point of a surface to each of some points on or close to it; see `prolongation`.

    Parameters
    ----------
    mesh : Mesh
        Every vertex must belong to a face.
    points : (p, 3) array

    Returns
    -------
    face : (p,) array of int
        Face of the nearest point.
    weights : (p, 3) array
        Barycentric coordinates there: rows are ≥ 0 and sum to 1.
    """
    corner_order = np.argsort(mesh.faces.ravel(), kind="stable")
    valence = np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices))
    first = np.cumsum(valence) - valence
    faces_at_vertices = corner_order // 3
    duals = _dual_sides(mesh)
    tree = KDTree(mesh.vertices)
    nearest_vertices = min(NEAREST_VERTICES, len(mesh.vertices))
    face, weights = np.empty(len(points), np.int64), np.empty((len(points), 3))
    for start in range(0, len(points), POINTS_AT_ONCE):
        part = slice(start, start + POINTS_AT_ONCE)
        _, vertex = tree.query(points[part], nearest_vertices)
        vertex = np.reshape(vertex, -1)
        # All pairs of a point and a face at one of its nearest vertices, point by point.
        place = np.repeat(first[vertex] - (np.cumsum(valence[vertex]) - valence[vertex]), valence[vertex])
        candidate = faces_at_vertices[place + np.arange(len(place))]
        pairs = valence[vertex].reshape(-1, nearest_vertices).sum(axis=1)
        face[part], weights[part] = _nearest(mesh, duals, points[part], candidate, pairs)
    return face, weights


def vertex_prolongation(copy: Mesh, mesh: Mesh, points: FloatArray, place: NDArray[np.int64]) -> csr_array:
    """Prolongation from a preprocessed copy: one entry where a vertex has a place there, else interpolation.

    Parameters
    ----------
    copy : Mesh
        With m vertices.
    mesh : Mesh
        With n vertices; those that no face uses get an empty row.
    points : (n, 3) array
        The vertices of `mesh` where `copy` is.
    place : (n,) array of int
        Vertex of the copy at the same place, −1 if there is none.

    Returns
    -------
    matrix : (n, m) sparse array
        ``matrix @ values`` carries values at the vertices of the copy over to those of the mesh.
    """
    used = np.zeros(len(points), bool)
    used[mesh.faces] = True
    placed = np.flatnonzero(used & (place >= 0))
    other = np.flatnonzero(used & (place < 0))
    rows, columns, weights = placed, place[placed], np.ones(len(placed))
    if len(other):
        interpolation = prolongation(copy, points[other]).tocoo()
        rows = np.concatenate([rows, other[interpolation.row]])
        columns = np.concatenate([columns, interpolation.col])
        weights = np.concatenate([weights, interpolation.data])
    shape = len(points), len(copy.vertices)
    return csr_array((weights, (rows, columns)), shape=shape)


def _nearest(
    mesh: Mesh, duals: FloatArray, points: FloatArray, candidate: NDArray[np.int64], pairs: NDArray[np.int64]
) -> tuple[NDArray[np.int64], FloatArray]:
    """Nearest face (p,) of each point and the weights (p, 3) there, of `pairs` candidates for each point.

    A point that does not project into a face is moved into it by clipping its barycentric coordinates. That
    is the face's nearest point or close to it, and several times faster than trimesh's exact one.
    """
    owner = np.repeat(np.arange(len(points)), pairs)
    offset = points[owner] - mesh.vertices[mesh.faces[candidate, 0]]
    second, third = np.einsum("cid,cd->ic", duals[candidate], offset)
    weights = np.maximum(np.stack([1 - second - third, second, third], axis=1), 0)
    weights /= weights.sum(axis=1, keepdims=True)
    sides = mesh.vertices[mesh.faces[candidate, 1:]] - mesh.vertices[mesh.faces[candidate, :1]]
    distance = np.linalg.norm(offset - np.einsum("ci,cid->cd", weights[:, 1:], sides), axis=1)
    least = np.minimum.reduceat(distance, np.cumsum(pairs) - pairs)
    chosen = np.flatnonzero(distance == least[owner])
    best = chosen[np.unique(owner[chosen], return_index=True)[1]]
    return candidate[best], weights[best]


def _dual_sides(mesh: Mesh) -> FloatArray:
    """(m, 2, 3): scalar products with x - a are the barycentric coordinates of b and c in a face abc."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    # A face without area has no coordinates; all of it counts as its corner a.
    squared = np.maximum((normal**2).sum(axis=1), np.finfo(float).tiny)[:, None]
    duals: FloatArray = np.stack([np.cross(c - a, normal), np.cross(normal, b - a)], axis=1)
    duals /= squared[:, None]
    return duals
