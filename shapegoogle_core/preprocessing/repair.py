# SPDX-License-Identifier: MIT
"""Repair: one vertex per place, one face per triangle, no unused vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.mesh.connectivity import used_points, used_vertices
from shapegoogle_core.mesh.measures import bounding_box, box_sides, cross_lengths, face_blocks, lengths
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.mesh.places import first_at_place, first_in_group, hashed_rows, repeated_keys

__all__ = ["repair", "repair_mapped"]

# Vertices closer than this share of the bounding-box diagonal are one: well above float32 rounding, far below
# what anyone models.
WELD_TOLERANCE = 1e-6
# ... but one stray vertex far away must not weld the whole model into a point.
WELD_TOLERANCE_OF_EDGE = 1e-3
# Vertices that may be at one place are first searched in cells this many times larger, few of which hold two
# vertices.
COARSE = 128


def repair(mesh: Mesh) -> Mesh:
    """Weld coincident vertices and drop everything that is not part of the surface.

    Vertices within 1e-6 of the bounding-box diagonal (and 1e-3 of the median edge) become one: the seams of
    glTF and flat-shaded exports, the triangle soup of STL. Faces that name a vertex twice or are flatter than
    that tolerance are dropped, and so are all but the first face on the same three vertices, and unreferenced
    vertices. The others keep their order and their coordinates, so a second repair changes nothing.

    Parameters
    ----------
    mesh : Mesh
        A point cloud is only welded.

    Returns
    -------
    repaired : Mesh
        Without faces if none had an area.

    Examples
    --------
    >>> from shapegoogle_core.mesh import Mesh
    >>> from shapegoogle_core.preprocessing import repair
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> repair(Mesh(corners, [[0, 1, 2], [3, 4, 5]]))
    Mesh('mesh', 4 vertices, 2 faces)
    """
    return repair_mapped(mesh)[0]


def repair_mapped(mesh: Mesh) -> tuple[Mesh, NDArray[np.int64]]:
    """Repair a mesh as `repair` does, and map its vertices to those that are left.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    repaired : Mesh
    place : (n,) array of int
        For each vertex of `mesh` the vertex of `repaired` at its place; −1 if there is none.
    """
    place = np.arange(len(mesh.vertices))
    while True:
        # Dropping faces can change the tolerance: repeated until nothing changes.
        repaired, step = _repair_once(mesh)
        if repaired is mesh:
            return mesh, place
        place = np.where(place < 0, -1, step[place])
        mesh = repaired


def _repair_once(mesh: Mesh) -> tuple[Mesh, NDArray[np.int64]]:
    """Repair a mesh with the tolerance that it has; the mesh itself if nothing changes."""
    if len(mesh.vertices) == 0:
        return mesh, np.empty(0, np.int64)
    tolerance = _weld_tolerance(mesh)
    representative = _weld(mesh.vertices, tolerance)
    if mesh.is_point_cloud:
        used, place = np.unique(representative, return_inverse=True)
        if len(used) == len(mesh.vertices):
            return mesh, used
        return Mesh(mesh.vertices[used], name=mesh.name), place
    faces = representative[mesh.faces]
    faces = faces[~_degenerate(mesh.vertices, faces, tolerance)]
    faces = faces[_first_of_each(faces, len(mesh.vertices))]
    used, compact = used_vertices(faces, len(mesh.vertices))
    if len(used) == len(mesh.vertices) and len(faces) == len(mesh.faces):
        return mesh, used
    place = np.full(len(mesh.vertices), -1)
    place[used] = np.arange(len(used))
    return Mesh(mesh.vertices[used], compact, mesh.name), place[representative]


def _weld_tolerance(mesh: Mesh) -> float:
    tolerance = WELD_TOLERANCE * float(np.linalg.norm(box_sides(used_points(mesh.vertices, mesh.faces))))
    if not mesh.is_point_cloud:
        sides = np.empty((3, len(mesh.faces)))
        for block, (a, b, c) in face_blocks(mesh.vertices, mesh.faces):
            sides[:, block] = lengths(b - a), lengths(c - b), lengths(a - c)
        count = np.count_nonzero(sides)
        count_longer = np.count_nonzero(WELD_TOLERANCE_OF_EDGE * sides > tolerance)
        if count > 0 and 2 * count_longer < count + 2:  # otherwise the median is longer as well
            median = float(np.median(sides[sides > 0]))
            tolerance = min(tolerance, WELD_TOLERANCE_OF_EDGE * median)
    return tolerance


def _weld(vertices: FloatArray, tolerance: float) -> NDArray[np.int64]:
    """Find for each vertex the first vertex at its place.

    Vertices are linked if they share a cell of a grid of side 2·tolerance. Of eight grids, shifted by half a
    cell along each set of axes, at least one has no wall between two points within the tolerance.
    Sorting cells needs no list of pairs, which has n² entries when many points crowd in one place.
    """
    first = first_at_place(vertices)
    places = np.flatnonzero(first == np.arange(len(vertices)))
    if tolerance <= 0:
        return first
    points = vertices[places]
    cells = (points - bounding_box(points)[0]) / (2 * tolerance)
    crowded = _may_share_a_cell(cells)
    cells = cells[crowded]
    links = []
    for shift in np.ndindex(2, 2, 2):
        cell = np.floor(cells + 0.5 * np.array(shift))
        leader = first_in_group(hashed_rows(cell.T))
        linked = np.flatnonzero((leader != np.arange(len(cell))) & (cell[leader] == cell).all(axis=1))
        links.append(np.stack([linked, leader[linked]]))
    row, column = np.concatenate(links, axis=1)
    if row.size == 0:
        return first
    graph = coo_array((np.ones(len(row), np.int8), (row, column)), shape=(len(cells), len(cells)))
    _, label = connected_components(graph, directed=False)
    leader_of_place = places.copy()
    leader_of_place[crowded] = places[crowded[first_in_group(label)]]
    rank = np.empty(len(vertices), np.int64)
    rank[places] = np.arange(len(places))
    return leader_of_place[rank[first]]


def _may_share_a_cell(cells: FloatArray) -> NDArray[np.int64]:
    """Vertices that can be in one cell with another, in any of the grids, from coordinates in cells.

    Two vertices in one cell are in one coarse cell as well, or both are close to a wall of those.
    """
    coarse = cells / COARSE
    cell = np.floor(coarse)
    coarse -= cell
    wall = 1.5 / COARSE  # no two in one cell are farther than one from each other; the rest is for rounding
    chosen: NDArray[np.bool_] = np.any((coarse < wall) | (coarse > 1 - wall), axis=1)
    chosen[repeated_keys(hashed_rows(cell.T))] = True
    return np.flatnonzero(chosen)


def _degenerate(vertices: FloatArray, faces: NDArray[np.int64], tolerance: float) -> NDArray[np.bool_]:
    """Faces that name a vertex twice or are no higher than the tolerance."""
    flat = np.empty(len(faces), bool)
    for block, (a, b, c) in face_blocks(vertices, faces):
        longest = np.maximum.reduce([lengths(b - a), lengths(c - b), lengths(a - c)])
        flat[block] = cross_lengths(b - a, c - a) <= tolerance * longest
    a, b, c = faces.T
    flat |= (a == b) | (b == c) | (c == a)
    return flat


def _first_of_each(faces: NDArray[np.int64], vertex_count: int) -> NDArray[np.int64]:
    """Return the indices of all faces that are the first on their three vertices, in order."""
    a, b, c = faces.T
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    middle = a + b + c - low - high
    everything = np.arange(len(faces))
    candidates = repeated_keys(hashed_rows(np.stack([low, middle, high])))
    if candidates.size == 0:
        return everything
    low, middle, high = low[candidates], middle[candidates], high[candidates]
    _, pair = np.unique(low * vertex_count + middle, return_inverse=True)
    _, first = np.unique(pair * vertex_count + high, return_index=True)
    return np.delete(everything, np.delete(candidates, first))
