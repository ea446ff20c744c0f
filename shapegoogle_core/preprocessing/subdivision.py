# SPDX-License-Identifier: MIT
"""Subdivision: long edges are split; the surface does not change."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.measures import lengths
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.preprocessing.triangulation import Indices, edge_table, flip_edges, split_edges

__all__ = ["subdivide"]

# New edges inside a flat region are split later than those on its outline, so that a thin face becomes a
# zigzag between points on its sides; without that (and flips) it would become ever thinner faces.
INNER_EDGE = 1.5
LEAST_OF_ROUND = 0.75


def subdivide(
    mesh: Mesh,
    floor: int,
    longest: float = np.inf,
    most: int | None = None,
    enough: int | None = None,
    region: Indices | None = None,
) -> Mesh:
    """Split long edges at their midpoints until there are `floor` vertices and none is too long.

    Every face of a split edge is split there, and within flat regions edges are flipped to make the triangles
    as even as possible (Delaunay). The surface does not change, point by point, it stays connected, and long
    thin faces become even ones.

    Parameters
    ----------
    mesh : Mesh
        With faces.
    floor : int
        Fewest vertices.
    longest : float, optional
        Longest edge wanted, in the unit of the mesh; edges inside a region may be half as long again.
    most : int, optional
        Most vertices; where this is reached, longer edges remain.
    enough : int, optional
        Number of vertices from which on only edges twice as long are split.
    region : (m,) array of int, optional
        Flat region of each face (see `flat_regions`); by default every face is one.

    Returns
    -------
    subdivided : Mesh
        The same vertices first. A few more than `floor` where edges of the same length are split together.
    """
    vertices, faces = mesh.vertices, mesh.faces.astype(np.int64)
    if region is None:
        region = np.arange(len(faces))
    while most is None or len(vertices) < most:
        edges = edge_table(faces)
        length = lengths(vertices[edges.ends[:, 0]] - vertices[edges.ends[:, 1]])
        length[edges.inside(region)] /= INNER_EDGE
        limit = longest if enough is None or len(vertices) < enough else 2 * longest
        chosen = _edges_to_split(length, floor - len(vertices), limit)
        if most is not None and np.count_nonzero(chosen) > most - len(vertices):
            chosen = _longest(length, most - len(vertices))
        if not chosen.any():
            break
        vertices, faces, region, new = split_edges(vertices, faces, region, edges, chosen)
        faces = flip_edges(vertices, faces, region, new)
    return mesh if len(vertices) == len(mesh.vertices) else Mesh(vertices, faces, mesh.name)


def _edges_to_split(length: FloatArray, missing: int, longest: float) -> NDArray[np.bool_]:
    """Choose edges for this round: not all at once, since splitting and flipping leave other edges."""
    least = np.inf
    if missing > 0:
        least = float(np.partition(length, -missing)[-missing]) if missing < len(length) else 0.0
    if length.max() > longest:
        least = min(least, longest)
    if least == np.inf:
        return np.zeros(len(length), bool)
    # Edges of the same length go together, so that the result does not depend on rounding.
    return np.asarray(length >= (1 - 1e-6) * max(least, LEAST_OF_ROUND * length.max()))


def _longest(length: FloatArray, count: int) -> NDArray[np.bool_]:
    chosen = np.zeros(len(length), bool)
    chosen[np.argsort(-length, kind="stable")[:count]] = True
    return chosen
