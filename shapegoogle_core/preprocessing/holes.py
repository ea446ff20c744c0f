# SPDX-License-Identifier: MIT
"""Hole filling: holes of a surface are closed, outlines of open sheets are not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapegoogle_core.mesh.connectivity import shared_sides, unique_edges
from shapegoogle_core.mesh.measures import box_sides, face_areas
from shapegoogle_core.mesh.mesh import Mesh

__all__ = ["boundary_half_edges", "boundary_loops", "close_holes"]

Boundary = tuple[NDArray[np.int64], NDArray[np.int64]]
"""Half-edges of the boundary, each in the direction of its face, and their faces."""

# A hole is closed if its lid has less than this share of the area of its part. A flat sheet closed along its
# outline would be doubled: share 1. A hemisphere's lid has 0.5, an end of a tube of length l and radius r
# has r/(2l), a hole in a surface next to nothing.
LARGEST_SHARE = 0.4
# A crack no wider than the weld tolerance has no lid.
LEAST_HEIGHT = 1e-6


def close_holes(mesh: Mesh, max_diameter: float = 0.45, boundary: Boundary | None = None) -> Mesh:
    """Close boundary loops by fans of triangles around their centroids.

    A loop is left open if it is wider than `max_diameter`, or if its lid has at least 0.4 of the area of the
    part (faces connected through edges) that it bounds: then it is the outline of a sheet, and a lid would
    double it. Polygon soup of open sheets does not change.

    Parameters
    ----------
    mesh : Mesh
        Repaired. Non-manifold edges do not count as boundary, and loops that touch themselves are cut into
        simple ones.
    max_diameter : float, optional
        Largest width of a hole, twice the distance from its centroid to its farthest vertex, as a share of
        the diagonal of the mesh's bounding box. 0 closes nothing.
    boundary : (b, 2) array of int, (b,) array of int, optional
        From `boundary_half_edges`, if it is known already.

    Returns
    -------
    closed : Mesh
        The same vertices and faces first, then one new vertex and a fan of faces for each hole. New faces
        run against the faces across each boundary edge, so an oriented surface stays oriented. A loop of
        three edges gets one face and no vertex.
    """
    if max_diameter <= 0:
        return mesh
    half_edges, owners = boundary_half_edges(mesh) if boundary is None else boundary
    if len(half_edges) == 0:
        return mesh
    loops = boundary_loops(half_edges)
    if not loops:
        return mesh
    edge = np.concatenate(loops)
    size = np.array([len(loop) for loop in loops])
    loop_of_edge = np.repeat(np.arange(len(loops)), size)
    starts = np.cumsum(size) - size
    start, end = mesh.vertices[half_edges[edge, 0]], mesh.vertices[half_edges[edge, 1]]
    # The centroid of the curve, so that it does not depend on where the curve's vertices crowd.
    length = np.linalg.norm(end - start, axis=1)
    perimeter = np.add.reduceat(length, starts)
    centroid = np.add.reduceat(length[:, None] * (start + end) / 2, starts) / perimeter[:, None]
    spokes = start - centroid[loop_of_edge]
    radius = np.maximum.reduceat(np.linalg.norm(spokes, axis=1), starts)
    lid_area = np.add.reduceat(np.linalg.norm(np.cross(spokes, end - start), axis=1) / 2, starts)
    part_area = _part_areas(mesh)[owners[edge[starts]]]
    diagonal = np.linalg.norm(box_sides(mesh.vertices))
    wanted = (
        (2 * radius <= max_diameter * diagonal)
        & (lid_area < LARGEST_SHARE * part_area)
        & (lid_area > LEAST_HEIGHT * diagonal * perimeter)
    )

    fanned = wanted & (size > 3)
    apex = len(mesh.vertices) + np.cumsum(fanned) - 1
    in_fan = fanned[loop_of_edge]
    fans = np.column_stack([half_edges[edge[in_fan], ::-1], apex[loop_of_edge[in_fan]]])
    triangles = half_edges[edge[(wanted & (size == 3))[loop_of_edge]]].reshape(-1, 3, 2)
    corners = np.stack([triangles[:, 0, 0], _third_corner(triangles), triangles[:, 0, 1]], axis=1)
    return Mesh(
        np.concatenate([mesh.vertices, centroid[fanned]]),
        np.concatenate([mesh.faces, fans, corners]),
        mesh.name,
    )


def boundary_loops(half_edges: NDArray[np.int64]) -> list[list[int]]:
    """Cut the boundary into simple loops.

    Parameters
    ----------
    half_edges : (b, 2) array
        Boundary edges, each in the direction of its face.

    Returns
    -------
    loops : list of list of int
        Indices of the edges of each loop in the order of a walk around it. Every edge is in one loop at
        most; no loop passes a vertex twice. Edges of a walk that ends without returning (possible only
        where faces meet in non-manifold edges) are in no loop.
    """
    following = _following(half_edges)
    ends = half_edges.tolist()
    edges_at: dict[int, list[int]] = {}
    free = [True] * len(ends)
    loops: list[list[int]] = []
    for first in range(len(ends)):
        if not free[first]:
            continue
        if loop := _plain_loop(first, following):
            loops.append(loop)
            for edge in loop:
                free[edge] = False
            continue
        edges_at = edges_at or _edges_at(half_edges)
        free[first] = False
        walk, path = [first], list(ends[first])
        place = {vertex: index for index, vertex in enumerate(path)}
        while True:
            here = edges_at[path[-1]]
            while here and not free[here[-1]]:
                here.pop()
            if not here:
                break
            edge = here.pop()
            free[edge] = False
            start, end = ends[edge]
            arrived = end if start == path[-1] else start
            walk.append(edge)
            if arrived in place:
                begin = place[arrived]
                loops.append(walk[begin:])
                for vertex in path[begin + 1 :]:
                    del place[vertex]
                del walk[begin:], path[begin + 1 :]
                if not walk:
                    break
            else:
                place[arrived] = len(path)
                path.append(arrived)
    return loops


def _following(half_edges: NDArray[np.int64]) -> list[int]:
    """Find the edge that leaves the end of each edge; −1 where other edges meet them."""
    starts, ends = half_edges.T
    count = int(half_edges.max(initial=-1)) + 1
    plain = (np.bincount(starts, minlength=count) == 1) & (np.bincount(ends, minlength=count) == 1)
    leaving = np.zeros(count, np.int64)
    leaving[starts] = np.arange(len(starts))
    following: list[int] = np.where(plain[ends], leaving[ends], -1).tolist()
    return following


def _plain_loop(first: int, following: list[int]) -> list[int]:
    """Walk around the loop of an edge; empty, and those edges not walked again, if other edges meet it."""
    loop, edge = [first], following[first]
    while edge != first:
        if edge < 0:
            for edge in loop:
                following[edge] = -1
            return []
        loop.append(edge)
        edge = following[edge]
    return loop


def _edges_at(half_edges: NDArray[np.int64]) -> dict[int, list[int]]:
    """List the edges at each vertex, as stacks."""
    edges_at: dict[int, list[int]] = {}
    # Edges that leave a vertex come last: `pop` takes them first, which follows the direction of the faces.
    for side in (1, 0):
        for edge, vertex in reversed(list(enumerate(half_edges[:, side].tolist()))):
            edges_at.setdefault(vertex, []).append(edge)
    return edges_at


def boundary_half_edges(mesh: Mesh) -> Boundary:
    """Find the edges of only one face.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    half_edges : (b, 2) array
        Each in the direction of its face.
    faces : (b,) array
        These faces.
    """
    edges, face_counts = unique_edges(mesh)
    edges = edges[face_counts == 1]
    if len(edges) == 0:
        return np.empty((0, 2), np.int64), np.empty(0, np.int64)
    on_boundary = np.zeros(len(mesh.vertices), bool)
    on_boundary[edges] = True
    # Only edges between two of these vertices need to be looked up.
    both = on_boundary[mesh.faces] & on_boundary[np.roll(mesh.faces, -1, axis=1)]
    face, side = np.nonzero(both)
    half_edges = np.stack([mesh.faces[face, side], mesh.faces[face, (side + 1) % 3]], axis=1).astype(np.int64)
    alone = np.isin(_edge_keys(half_edges, mesh), _edge_keys(edges.astype(np.int64), mesh))
    return half_edges[alone], face[alone]


def _edge_keys(half_edges: NDArray[np.int64], mesh: Mesh) -> NDArray[np.int64]:
    return np.asarray(half_edges.min(axis=1) * len(mesh.vertices) + half_edges.max(axis=1))


def _part_areas(mesh: Mesh) -> NDArray[np.float64]:
    """Area of each face's part: of all faces that are connected to it through edges."""
    row, column = (side // 3 for side in shared_sides(mesh.faces, len(mesh.vertices)))
    count = len(mesh.faces)
    graph = coo_array((np.ones(len(row), np.int8), (row, column)), shape=(count, count))
    _, part = connected_components(graph, directed=False)
    area_of_part = np.bincount(part, face_areas(mesh)).astype(np.float64)
    return area_of_part[part]


def _third_corner(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """Vertex that is not on the first edge, of loops of three edges."""
    second = triangles[:, 1]
    on_first = (second[:, :1] == triangles[:, 0]).any(axis=1)
    return np.where(on_first, second[:, 1], second[:, 0])
