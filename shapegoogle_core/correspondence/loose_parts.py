# SPDX-License-Identifier: MIT
"""Loose parts of a shape, such as eyes and clothes, and the ties that join them."""

from __future__ import annotations

import math

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from shapegoogle_core.laplacian import Operator
from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh

__all__ = ["largest_parts", "tied", "ties_between_parts"]

Indices = NDArray[np.int64]

# Number of loose parts that are kept, the largest ones: vertices of others take the nearest values.
_MOST_PARTS = 64
# A part is tied to the rest at its nearest vertex and at those that are at most this much farther away, in
# units of √area; this many of them at most.
_TIE_REACH, _MOST_TIES = 0.02, 30


def _parts(mesh: Mesh) -> tuple[int, IntArray]:
    start, end = mesh.faces[:, [0, 1]].ravel(), mesh.faces[:, [1, 2]].ravel()
    graph = sparse.coo_array((np.ones(len(start), np.int8), (start, end)), shape=2 * (len(mesh.vertices),))
    count, part = connected_components(graph, directed=False)
    return int(count), part


def largest_parts(mesh: Mesh) -> tuple[Mesh, NDArray[np.bool_]]:
    """Keep the largest loose parts.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    kept_mesh : Mesh
    kept : (n,) array of bool
        Mask of the vertices that it has.
    """
    count, part = _parts(mesh)
    if count <= _MOST_PARTS:
        return mesh, np.ones(len(mesh.vertices), bool)
    areas = np.bincount(part[mesh.faces[:, 0]], face_areas(mesh), count)
    kept = np.isin(part, np.argsort(-areas, kind="stable")[:_MOST_PARTS])
    faces = (np.cumsum(kept) - 1)[mesh.faces[kept[mesh.faces[:, 0]]]]
    return Mesh(mesh.vertices[kept], faces, mesh.name), kept


def ties_between_parts(mesh: Mesh) -> tuple[Indices, FloatArray]:
    """Choose pairs of vertices that join the loose parts into one.

    The parts are tied one by one, the nearest first, to those before them where they come closest: the eye to
    its socket, whatever the pose of the head.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    pairs : (t, 2) array of int
    lengths : (t,) array
        Distances of these pairs.
    """
    count, part = _parts(mesh)
    pairs, lengths = [np.empty((0, 2), np.int64)], [np.empty(0)]
    areas = np.bincount(part[mesh.faces[:, 0]], face_areas(mesh), count)
    newest = int(areas.argmax())
    outside = np.flatnonzero(part != newest)
    distance, nearest = np.full(len(outside), np.inf), np.zeros(len(outside), np.int64)
    while len(outside):
        members = np.flatnonzero(part == newest)
        to_newest, index = map(np.asarray, KDTree(mesh.vertices[members]).query(mesh.vertices[outside]))
        closer = to_newest < distance
        distance[closer], nearest[closer] = to_newest[closer], members[index[closer]]
        newest = int(part[outside[distance.argmin()]])
        own = np.flatnonzero(part[outside] == newest)
        own = own[np.argsort(distance[own], kind="stable")][:_MOST_TIES]
        own = own[distance[own] <= distance[own[0]] + _TIE_REACH]
        pairs.append(np.stack([outside[own], nearest[own]], axis=1))
        lengths.append(distance[own])
        rest = part[outside] != newest
        outside, distance, nearest = outside[rest], distance[rest], nearest[rest]
    return np.concatenate(pairs), np.concatenate(lengths)


def tied(operator: Operator, ties: Indices) -> Operator:
    """Add ties to an operator: heat crosses them as an edge between two equilateral faces, with cot 60°.

    Parameters
    ----------
    operator : Operator
    ties : (t, 2) array of int

    Returns
    -------
    tied : Operator
    """
    if not len(ties):
        return operator
    start, end = ties.T
    weight = np.full(len(ties), 1 / math.sqrt(3))
    links = sparse.coo_array(
        (
            np.concatenate([weight, weight, -weight, -weight]),
            (np.concatenate([start, end, start, end]), np.concatenate([start, end, end, start])),
        ),
        shape=operator.stiffness.shape,
    )
    return Operator(sparse.csc_array(operator.stiffness + links), operator.mass)
