# SPDX-License-Identifier: MIT
"""Repair: one vertex per place, one face per triangle, nothing left over."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh, face_areas

__all__ = ["check_surface", "repair", "repair_mapped"]

# Vertices closer than this share of the bounding-box diagonal are one: well above float32 rounding, far below
# what anyone models.
WELD_TOLERANCE = 1e-6
# ... but one stray vertex far away must not weld the whole model into a point.
WELD_TOLERANCE_OF_EDGE = 1e-3
# A surface with less area than this share of its squared extent is a line drawn with float32 rounding errors.
LEAST_RELATIVE_AREA = 1e-7


def check_surface(mesh: Mesh) -> None:
    """Raise unless the mesh is a surface that can be described.

    Parameters
    ----------
    mesh : Mesh

    Raises
    ------
    MeshError
        If there are no faces or fewer than four vertices, all points coincide, the surface has no area, or
        the coordinates are so large or small that areas leave the range of floating-point numbers.
    """
    count = len(mesh.vertices)
    if mesh.is_point_cloud:
        raise MeshError(
            f"{mesh.name!r} has no faces and {count} points, where a surface of triangles is needed: "
            "export the mesh with its faces"
        )
    if count < 4:
        raise MeshError(f"{mesh.name!r} has only {count} vertices; a shape needs at least 4")
    used = np.zeros(count, bool)
    used[mesh.faces] = True
    corners = mesh.vertices[used]
    with np.errstate(over="ignore"):
        extent = float(np.ptp(corners, axis=0).max())
    if extent <= 4 * np.finfo(np.float64).eps * float(np.abs(corners).max()):
        raise MeshError(f"{mesh.name!r}: all points of its faces coincide; export the mesh again")
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        area = mesh.area
        relative_area = face_areas(Mesh(mesh.vertices / extent, mesh.faces)).sum() if extent < np.inf else 0.0
    if relative_area <= LEAST_RELATIVE_AREA and extent < np.inf:
        raise MeshError(
            f"{mesh.name!r}: its faces have no area (all points lie on a line); export the mesh again"
        )
    if not 0 < area < np.inf:
        raise MeshError(
            f"{mesh.name!r} is {extent:g} units long, so that areas leave the range of numbers; "
            "scale the mesh to a usual size"
        )


def repair(mesh: Mesh) -> Mesh:
    """Weld coincident vertices and drop what is no part of the surface.

    Vertices within 1e-6 of the bounding-box diagonal (and 1e-3 of the median edge) become one: the seams of
    glTF and flat-shaded exports, the triangle soup of STL. Faces that name a vertex twice or are flatter than
    that tolerance go, so do all but the first face on the same three vertices, and unreferenced vertices.
    Kept vertices and faces keep their order and their coordinates, so repairing twice changes nothing more.

    Parameters
    ----------
    mesh : Mesh
        A point cloud is only welded.

    Returns
    -------
    repaired : Mesh
        May have no faces left if none had an area.
    """
    return repair_mapped(mesh)[0]


def repair_mapped(mesh: Mesh) -> tuple[Mesh, NDArray[np.int64]]:
    """Repair a mesh as `repair` does, and say where its vertices went.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    repaired : Mesh
    place : (n,) array of int
        For each vertex of `mesh` the vertex of `repaired` that stands for it; −1 if none does.
    """
    place = np.arange(len(mesh.vertices))
    while True:
        # Dropping faces can change the tolerance; the end is where nothing changes any more.
        repaired, step = _repair_once(mesh)
        if len(repaired.vertices) == len(mesh.vertices) and len(repaired.faces) == len(mesh.faces):
            return mesh, place
        place = np.where(place < 0, -1, step[place])
        mesh = repaired


def _repair_once(mesh: Mesh) -> tuple[Mesh, NDArray[np.int64]]:
    if len(mesh.vertices) == 0:
        return mesh, np.empty(0, np.int64)
    tolerance = _weld_tolerance(mesh)
    representative = _weld(mesh.vertices, tolerance)
    if mesh.is_point_cloud:
        used, place = np.unique(representative, return_inverse=True)
        return Mesh(mesh.vertices[used], name=mesh.name), place
    faces = representative[mesh.faces]
    faces = faces[~_degenerate(mesh.vertices, faces, tolerance)]
    faces = faces[_first_of_each(faces, len(mesh.vertices))]
    used, compact = np.unique(faces, return_inverse=True)
    place = np.full(len(mesh.vertices), -1)
    place[used] = np.arange(len(used))
    return Mesh(mesh.vertices[used], compact.reshape(-1, 3), mesh.name), place[representative]


def _weld_tolerance(mesh: Mesh) -> float:
    corners = mesh.vertices if mesh.is_point_cloud else mesh.vertices[mesh.faces.ravel()]
    tolerance = WELD_TOLERANCE * float(np.linalg.norm(np.ptp(corners, axis=0)))
    if not mesh.is_point_cloud:
        triangles = mesh.vertices[mesh.faces]
        lengths = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).ravel()
        lengths = lengths[lengths > 0]
        if lengths.size:
            tolerance = min(tolerance, WELD_TOLERANCE_OF_EDGE * float(np.median(lengths)))
    return tolerance


def _weld(vertices: FloatArray, tolerance: float) -> NDArray[np.int64]:
    """For each vertex the first vertex at its place.

    Vertices are linked if they share a cell of a grid of side 2·tolerance. Of eight grids, shifted by half a
    cell along each set of axes, at least one has no wall between two points within the tolerance.
    Sorting cells needs no list of pairs, which has n² entries when many points crowd in one place.
    """
    first = _first_in_group(_hash(vertices + 0.0))  # + 0.0: minus zero is zero
    same = (vertices[first] == vertices).all(axis=1)
    first = np.where(same, first, np.arange(len(vertices)))  # two places with one hash, if ever, stay apart
    places = np.flatnonzero(first == np.arange(len(vertices)))
    if tolerance <= 0:
        return first
    points = vertices[places]
    cells = (points - points.min(axis=0)) / (2 * tolerance)
    links = []
    for shift in np.ndindex(2, 2, 2):
        cell = np.floor(cells + 0.5 * np.array(shift))
        leader = _first_in_group(_hash(cell))
        linked = np.flatnonzero((leader != np.arange(len(points))) & (cell[leader] == cell).all(axis=1))
        links.append(np.stack([linked, leader[linked]]))
    row, column = np.concatenate(links, axis=1)
    if row.size == 0:
        return first
    graph = coo_array((np.ones(len(row), np.int8), (row, column)), shape=(len(points), len(points)))
    _, label = connected_components(graph, directed=False)
    leader_of_place = places[_first_in_group(label)]
    rank = np.empty(len(vertices), np.int64)
    rank[places] = np.arange(len(places))
    welded: NDArray[np.int64] = leader_of_place[rank[first]]
    return welded


def _hash(rows: FloatArray) -> NDArray[np.uint64]:
    """One 64-bit number per row of three: equal rows have equal numbers, others almost surely not."""
    bits = np.ascontiguousarray(rows).view(np.uint64)
    mixed = np.zeros(len(rows), np.uint64)
    for axis in range(3):
        # Rounds of the splitmix64 finaliser; unsigned arithmetic wraps on purpose.
        mixed = (mixed ^ bits[:, axis]) * np.uint64(0xBF58476D1CE4E5B9)
        mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        mixed ^= mixed >> np.uint64(31)
    return mixed


def _first_in_group(keys: NDArray[np.uint64] | IntArray) -> NDArray[np.int64]:
    """For each entry the index of the first entry with the same key."""
    _, first, group = np.unique(keys, return_index=True, return_inverse=True)
    indices: NDArray[np.int64] = first[group]
    return indices


def _degenerate(vertices: FloatArray, faces: NDArray[np.int64], tolerance: float) -> NDArray[np.bool_]:
    """Faces that name a vertex twice or are no higher than the tolerance."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    double_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.maximum.reduce([np.linalg.norm(side, axis=1) for side in (b - a, c - b, a - c)])
    repeated = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    flat: NDArray[np.bool_] = repeated | (double_area <= tolerance * longest)
    return flat


def _first_of_each(faces: NDArray[np.int64], vertex_count: int) -> NDArray[np.int64]:
    """Return the indices of all faces that are the first on their three vertices, in order."""
    low, middle, high = np.sort(faces, axis=1).T
    _, pair = np.unique(low * vertex_count + middle, return_inverse=True)
    _, first = np.unique(pair * vertex_count + high, return_index=True)
    return np.sort(first)
