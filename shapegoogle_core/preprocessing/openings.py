# SPDX-License-Identifier: MIT
"""Where a surface ends: points of its open boundary and of the lids that were put on its holes.

Near a cut a descriptor differs from that of the whole. These points tell how near it is.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.drawing import draw_points
from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["opening_points"]

# Distance of neighbouring points, as a share of √area, and the largest number of either sort of points: a
# polygon soup has open edges everywhere.
_SPACING = 0.015
_MOST_POINTS = 20_000


def opening_points(closed: Mesh, boundary: NDArray[np.int64], lids: NDArray[np.integer]) -> FloatArray:
    """Spread points over the boundary that a mesh had, and over the lids of its holes.

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
        0.015 √area apart, or farther if there would be many more than 20,000 on boundary or lids; none for a
        closed surface.
    """
    if len(boundary) == 0:
        return np.empty((0, 3))
    spacing = _SPACING * math.sqrt(closed.area)
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
