# SPDX-License-Identifier: MIT
"""Where a surface was cut off: points of its open boundary and of the lids that were put on its holes.

Near a cut a descriptor differs from that of the whole. These points tell how near it is. Eyes of a scan and
its small holes cut nothing off.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.mesh.drawing import draw_points
from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["opening_points"]

# Distance of neighbouring points, as a share of √area, and the largest number of either sort of points: a
# polygon soup has open edges everywhere.
_SPACING = 0.015
_MOST_POINTS = 20_000
# Where something was cut off, an opening is at least this wide, as a multiple of √area. Of 651 parts of
# creatures, 9 have none that wide, chains and snakes; of 62 whole ones with five holes, 4 have one, of 62
# with two openings like eyes none.
_LEAST_WIDTH = 0.2


def opening_points(closed: Mesh, boundary: NDArray[np.int64], lids: NDArray[np.integer]) -> FloatArray:
    """Spread points over the boundary that a mesh had, and over the lids of its holes, if it was cut off.

    Parameters
    ----------
    closed : Mesh
        With lids.
    boundary : (b, 2) array of int
        Edges of the boundary before holes were closed.
    lids : (f, 3) array of int
        Faces of the lids.

    Returns
    -------
    points : (p, 3) array
        0.015 √area apart, or farther if there would be many more than 20,000 on boundary or lids. None for a
        closed surface, nor if no opening is wider than 0.2 √area.
    """
    unit = math.sqrt(closed.area)
    if len(boundary) == 0 or _largest_width(closed, boundary) < _LEAST_WIDTH * unit:
        return np.empty((0, 3))
    spacing = _SPACING * unit
    boundary = boundary[:: math.ceil(len(boundary) / _MOST_POINTS)]
    start, end = closed.vertices[boundary[:, 0]], closed.vertices[boundary[:, 1]]
    lengths = np.linalg.norm(end - start, axis=1)
    apart = max(spacing, lengths.sum() / _MOST_POINTS)
    counts = np.maximum(1, np.ceil(lengths / apart)).astype(int)
    edge = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[edge]
    points = start[edge] + share[:, None] * (end - start)[edge]
    areas = face_areas(Mesh(closed.vertices, lids)) if len(lids) else np.zeros(0)
    count = min(_MOST_POINTS, math.ceil(areas.sum() / spacing**2))
    if count == 0:
        return np.asarray(points, np.float64)
    face, corners = draw_points(areas, count, np.random.default_rng(0))
    on_lids = (corners[:, :, None] * closed.vertices[lids[face]]).sum(axis=1)
    return np.asarray(np.concatenate([points, on_lids]), np.float64)


def _largest_width(mesh: Mesh, boundary: NDArray[np.int64]) -> float:
    """Measure the widest connected piece of the boundary: twice the distance from its centroid."""
    _, edges = np.unique(boundary, return_inverse=True)
    start, end = edges.reshape(boundary.shape).T
    count = int(edges.max()) + 1
    graph = coo_array((np.ones(len(start), np.int8), (start, end)), (count, count))
    pieces, piece = connected_components(graph, directed=False)
    piece = piece[start]
    corners = mesh.vertices[boundary]
    lengths = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    lengths += np.finfo(float).tiny  # an edge may have no length
    weighted = lengths[:, None] * corners.mean(axis=1)
    sums = np.stack([np.bincount(piece, column, pieces) for column in weighted.T], axis=1)
    centroids = sums / np.bincount(piece, lengths, pieces)[:, None]
    return 2 * float(np.linalg.norm(corners[:, 0] - centroids[piece], axis=1).max())
