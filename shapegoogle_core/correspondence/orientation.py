# SPDX-License-Identifier: MIT
"""Consistent orientation of faces."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components

from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.mesh.mesh import IntArray, Mesh

__all__ = ["oriented_faces"]

# A closed surface of unit area encloses at most 1/(6√π) = 0.094. Smaller volumes do not decide on a side.
_SMALLEST_VOLUME = 1e-3


def oriented_faces(mesh: Mesh) -> tuple[IntArray, bool]:
    """Orient faces as their neighbours, and outwards if the surface encloses a volume.

    Each part is oriented by the volume that it encloses with its centre. An open part that encloses almost
    none keeps the orientation of most of its faces.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    faces : (m, 3) array of int
    outward : bool
        Whether the surface encloses a volume, so that faces are oriented outwards.
    """
    m, n = len(mesh.faces), len(mesh.vertices)
    sides = mesh.faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2).astype(np.int64)
    keys = sides.min(axis=1) * n + sides.max(axis=1)
    _, place, counts = np.unique(keys, return_inverse=True, return_counts=True)
    order = np.argsort(keys, kind="stable")
    order = order[counts[place[order]] == 2]  # edges of more than two faces connect none
    one, other = order[::2], order[1::2]
    # Consistently oriented neighbours traverse their edge in opposite directions.
    same_way = sides[one, 0] == sides[other, 0]
    pairs = np.concatenate([np.stack([one, other]) // 3, np.stack([other, one]) // 3], axis=1)
    value = np.tile(np.where(same_way, 2, 1), 2).astype(np.int8)
    graph = sparse.csr_array(sparse.coo_array((value, (pairs[0], pairs[1])), shape=(m, m)))
    graph.data = np.minimum(graph.data, 2)
    part_count, part = connected_components(graph, directed=False)
    flipped = np.zeros(m, bool)
    for first in np.unique(part, return_index=True)[1]:
        visited, parent = breadth_first_order(graph, int(first), directed=False)
        own = visited[1:]
        against = np.asarray(graph[own, parent[own]]).ravel() == 2 if len(own) else np.empty(0, bool)
        for face, before, turn in zip(own.tolist(), parent[own].tolist(), against.tolist(), strict=True):
            flipped[face] = flipped[before] ^ turn
    areas = face_areas(mesh)
    part_areas = np.bincount(part, areas, part_count)
    corners = mesh.vertices[mesh.faces]
    centers = np.stack(
        [np.bincount(part, areas * axis, part_count) for axis in corners.mean(axis=1).T], axis=1
    )
    corners = corners - (centers / np.maximum(part_areas, np.finfo(float).tiny)[:, None])[part][:, None]
    volumes = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volumes[flipped] *= -1
    enclosed = np.bincount(part, volumes, part_count) / np.maximum(part_areas, np.finfo(float).tiny) ** 1.5
    tells = np.abs(enclosed) > _SMALLEST_VOLUME
    minority = np.bincount(part, areas * np.where(flipped, 1, -1), part_count) > 0
    flipped ^= np.where(tells, enclosed < 0, minority)[part]
    outward = bool(part_areas[tells].sum() > 0.5 * part_areas.sum())
    return np.where(flipped[:, None], mesh.faces[:, ::-1], mesh.faces).astype(np.int32), outward
