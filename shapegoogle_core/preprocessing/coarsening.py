# SPDX-License-Identifier: MIT
"""Coarsening: a surface loses the vertices that it does not need, so that how it was cut does not matter."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from shapegoogle_core.mesh.connectivity import any_corner, used_vertices
from shapegoogle_core.mesh.measures import cross_products, dots, lengths
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.preprocessing.ear_clipping import Triangle, clip_ears, outline_around
from shapegoogle_core.preprocessing.flat_regions import flat_regions, height_tolerance
from shapegoogle_core.preprocessing.triangulation import EdgeTable, Indices, edge_table, flip_edges

__all__ = ["coarsen"]

_TINY = float(np.finfo(float).tiny)


def coarsen(mesh: Mesh) -> tuple[Mesh, Indices]:
    """Remove the vertices inside flat regions and on straight edges between them.

    What is left are the corners of the surface: the same ones whether a modeller cut it into long triangles,
    a grid, or triangles split in four. The surface does not change, point by point, up to `height_tolerance`.

    Parameters
    ----------
    mesh : Mesh
        Repaired.

    Returns
    -------
    coarse : Mesh
        The vertices that are left, in their order, and in each flat region the Delaunay triangles. A vertex
        may be left over in a region that is not a simple polygon. The mesh itself if no two faces lie in a
        plane.
    region : (m,) array of int
        Flat region of each face of `coarse`.
    """
    vertices, faces = mesh.vertices, mesh.faces.astype(np.int64)
    edges = edge_table(faces)
    region = flat_regions(mesh, edges)
    if region.max() + 1 == len(region):
        return mesh, region
    tolerance = height_tolerance(vertices)
    near = _near_flat_regions(faces, region, edges)
    found = _coarsened(vertices, faces, region, near, tolerance)
    if found is None:
        found = _coarsened(vertices, faces, region, np.ones(len(vertices), bool), tolerance)
        assert found is not None
    faces, region = found
    used, compact = used_vertices(faces, len(vertices))
    return Mesh(vertices[used], compact, mesh.name), region


def _near_flat_regions(faces: Indices, region: Indices, edges: EdgeTable) -> NDArray[np.bool_]:
    """Find the vertices of regions of several faces, and those that may be removed, with their neighbours.

    Most faces of a curved surface are regions of their own, and nothing changes there.
    """
    count = int(faces.max()) + 1
    near = np.zeros(count, bool)
    near[faces[np.bincount(region)[region] > 1]] = True
    outline_count = np.bincount(edges.ends[~edges.inside(region)].ravel(), minlength=count)
    removable = (outline_count == 0) | (outline_count == 2)
    near |= removable
    near[edges.ends[any_corner(removable, edges.ends)]] = True
    return near


def _coarsened(
    vertices: FloatArray, faces: Indices, region: Indices, near: NDArray[np.bool_], tolerance: float
) -> tuple[Indices, Indices] | None:
    """Coarsen the faces around some vertices.

    Returns
    -------
    faces : (k, 3) array of int
        Those that were there before come first, in their order.
    region : (k,) array of int
        None instead of both if other faces would have to change too.
    """
    part = np.flatnonzero(any_corner(near, faces))
    used, part_faces = used_vertices(faces[part], len(vertices))
    found = _remove_vertices(vertices[used], part_faces.astype(np.int64), region[part], near[used], tolerance)
    if found is None:
        return None
    part_faces, part_region, source = found
    part_faces = used[flip_edges(vertices[used], part_faces, part_region)]
    old = source >= 0
    kept = np.ones(len(faces), bool)
    kept[part] = False
    kept[part[source[old]]] = True
    faces[part[source[old]]] = part_faces[old]
    return (
        np.concatenate([faces[kept], part_faces[~old]]),
        np.concatenate([region[kept], part_region[~old]]),
    )


def _remove_vertices(
    vertices: FloatArray, faces: Indices, region: Indices, complete: NDArray[np.bool_], tolerance: float
) -> tuple[Indices, Indices, Indices] | None:
    """Remove vertices, about a quarter of those that can go in each round, until none is left.

    Parameters
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array of int
        Of a whole mesh, or a part of it.
    region : (m,) array of int
    complete : (n,) array of bool
        Vertices of which all faces are there.
    tolerance : float

    Returns
    -------
    faces : (k, 3) array of int
    region : (k,) array of int
    source : (k,) array of int
        Number of the face that a face was before; −1 for the new ones, which come last.
        None instead of all three if a vertex could go of whose neighbours not all are complete.
    """
    source = np.arange(len(faces))
    stuck = np.zeros(len(vertices), bool)
    while True:
        edges = edge_table(faces)
        removable, ways = _removable(vertices, faces, edges, edges.inside(region), tolerance)
        removable &= complete
        if (removable[edges.ends] & ~complete[edges.ends[:, ::-1]]).any():
            return None
        chosen = _independent(removable & ~stuck, edges.ends)
        if not chosen.any():
            return faces, region, source
        vertex, target = ways[:, chosen[ways[0]]]
        vertex, target = _valid_moves(vertices, faces, edges, vertex, target, tolerance)
        chosen[vertex] = False
        removed, new_faces, new_regions = _clipped(vertices, faces, region, edges, chosen, tolerance)
        stuck |= chosen
        # Around a vertex that is gone, others may be able to go now.
        gone = np.zeros(len(vertices), bool)
        gone[vertex] = gone[removed] = True
        stuck[edges.ends[any_corner(gone, edges.ends)]] = False
        moved = np.arange(len(vertices))
        moved[vertex] = target
        gone[vertex] = False
        kept = ~any_corner(gone, faces)
        faces = moved[faces]
        a, b, c = faces.T
        kept &= (a != b) & (b != c) & (c != a)
        faces = np.concatenate([faces[kept], new_faces])
        region = np.concatenate([region[kept], new_regions])
        source = np.concatenate([source[kept], np.full(len(new_faces), -1)])


def _clipped(
    vertices: FloatArray,
    faces: Indices,
    region: Indices,
    edges: EdgeTable,
    chosen: NDArray[np.bool_],
    tolerance: float,
) -> tuple[Indices, Indices, Indices]:
    """Remove vertices with many neighbours, no one of which sees all others, by ear clipping.

    Returns
    -------
    removed : (r,) array of int
        Those of the chosen vertices that can go.
    faces : (k, 3) array of int
        New faces instead of those around the vertices.
    region : (k,) array of int
        Their regions.
    """
    removed: list[int] = []
    triangles: list[Triangle] = []
    owners: list[int] = []
    if chosen.any():
        new_edges: set[tuple[int, int]] = set()
        around: dict[int, dict[int, list[list[int]]]] = {}
        for number in np.flatnonzero(any_corner(chosen, faces)).tolist():
            face = faces[number].tolist()
            vertex = face[int(np.argmax(chosen[face]))]
            around.setdefault(vertex, {}).setdefault(int(region[number]), []).append(face)
        for vertex, fans in around.items():
            found = [_clip_fan(vertices, vertex, fan, tolerance) for fan in fans.values()]
            inner = {
                edge
                for fan, clipped in zip(fans.values(), found, strict=True)
                for edge in _sides(clipped) - _sides(fan)
            }
            # An edge that there is already would get more than two faces.
            if all(found) and not (inner & new_edges or _any_known(inner, edges.ends)):
                removed.append(vertex)
                for owner, fan in zip(fans, found, strict=True):
                    triangles += fan
                    owners += [owner] * len(fan)
                new_edges |= inner
    return (
        np.array(removed, np.int64),
        np.array(triangles, np.int64).reshape(-1, 3),
        np.array(owners, np.int64),
    )


def _clip_fan(
    vertices: FloatArray, vertex: int, fan: Sequence[Sequence[int]], tolerance: float
) -> list[Triangle]:
    """Triangulate what the faces of one region around a vertex cover; empty if that cannot be done."""
    outline = outline_around(vertex, fan)
    if len(outline) < 3:
        return []
    points = vertices[outline] - vertices[vertex]
    following = vertices[[*outline[1:], outline[0]]] - vertices[vertex]
    # Row by row, since sums of columns are added in another order.
    normal = np.ascontiguousarray(cross_products(points, following).T).sum(axis=0)
    first = points[np.argmax((points**2).sum(axis=1))]
    (a, b, c), (x, y, z) = normal.tolist(), first.tolist()
    second = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
    axes = np.stack([axis / max(float(np.linalg.norm(axis)), _TINY) for axis in (first, second)])
    return clip_ears(outline, points @ axes.T, tolerance)


def _sides(faces: Sequence[Sequence[int]]) -> set[tuple[int, int]]:
    return {(min(a, b), max(a, b)) for face in faces for a, b in combinations(face, 2)}


def _any_known(wanted: set[tuple[int, int]], ends: Indices) -> bool:
    """Whether any edge is among those of a table, which are in order."""
    if not wanted:
        return False
    count = int(ends.max()) + 1
    keys = ends[:, 0] * count + ends[:, 1]
    low, high = np.array(sorted(wanted)).T
    place = np.searchsorted(keys, low * count + high)
    return bool((keys[np.minimum(place, len(keys) - 1)] == low * count + high).any())


def _removable(
    vertices: FloatArray, faces: Indices, edges: EdgeTable, inside: NDArray[np.bool_], tolerance: float
) -> tuple[NDArray[np.bool_], Indices]:
    """Find the vertices inside flat regions and on straight edges, and the neighbours that they may move to.

    Returns
    -------
    removable : (n,) array of bool
    ways : (2, k) array of int
        Vertices and neighbours.
    """
    count = len(vertices)
    used = np.zeros(count, bool)
    used[faces] = True
    outline = edges.ends[~inside]
    outline_count = np.bincount(outline.ravel(), minlength=count)
    flat = used & (outline_count == 0)
    # The two outline edges of a vertex, one after the other.
    both = np.concatenate([outline, outline[:, ::-1]])
    both = both[outline_count[both[:, 0]] == 2]
    both = both[np.argsort(both[:, 0], kind="stable")]
    middle, start, end = both[::2, 0], both[::2, 1], both[1::2, 1]
    along = vertices[end] - vertices[start]
    offset = vertices[middle] - vertices[start]
    share = dots(offset, along) / np.maximum(dots(along, along), np.finfo(float).tiny)
    distance = lengths(offset - share[:, None] * along)
    straight = (distance <= tolerance) & (share > 0) & (share < 1)
    middle, start, end = middle[straight], start[straight], end[straight]
    removable = flat.copy()
    removable[middle] = True
    inner = np.concatenate([edges.ends, edges.ends[:, ::-1]])
    inner = inner[flat[inner[:, 0]]]
    ways = np.concatenate([inner.T, np.stack([middle, start]), np.stack([middle, end])], axis=1)
    return removable, ways


def _independent(wanted: NDArray[np.bool_], ends: Indices) -> NDArray[np.bool_]:
    """Choose wanted vertices of which no two are neighbours, those with few neighbours first."""
    degree = np.bincount(ends.ravel(), minlength=len(wanted))
    between = ends[wanted[ends[:, 0]] & wanted[ends[:, 1]]]
    neighbours: dict[int, list[int]] = {}
    for one, other in between.tolist():
        neighbours.setdefault(one, []).append(other)
        neighbours.setdefault(other, []).append(one)
    candidates = np.flatnonzero(wanted)
    free = set(candidates.tolist())
    chosen = []
    for vertex in candidates[np.argsort(degree[candidates], kind="stable")].tolist():
        if vertex in free:
            chosen.append(vertex)
            free.difference_update(neighbours.get(vertex, ()))
    result = np.zeros(len(wanted), bool)
    result[chosen] = True
    return result


def _valid_moves(
    vertices: FloatArray, faces: Indices, edges: EdgeTable, vertex: Indices, target: Indices, tolerance: float
) -> tuple[Indices, Indices]:
    """Choose for each vertex the nearest neighbour to which it can move without changing the surface."""
    corners = faces.ravel()
    by_vertex = np.argsort(corners, kind="stable")
    start = np.searchsorted(corners[by_vertex], np.arange(len(vertices) + 1))
    size = start[vertex + 1] - start[vertex]
    move = np.repeat(np.arange(len(vertex)), size)
    corner = by_vertex[np.arange(len(move)) - np.repeat(np.cumsum(size) - size - start[vertex], size)]
    second, third = faces[corner // 3, (corner % 3 + 1) % 3], faces[corner // 3, (corner % 3 + 2) % 3]
    goal = target[move]
    vanishes = (second == goal) | (third == goal)
    opposite = vertices[third] - vertices[second]
    to_second, to_third = vertices[second] - vertices[goal], vertices[third] - vertices[goal]
    before = cross_products(vertices[second] - vertices[vertex[move]], opposite).T
    after = cross_products(to_second, opposite).T
    longest = np.maximum.reduce([dots(side, side) for side in (to_second, to_third, opposite)])
    # A face keeps its side, and does not become as low as what counts as flat.
    stays = (dots(before, after) > 0) & (dots(after, after) > tolerance**2 * longest)
    valid = np.bincount(move, ~vanishes & ~stays, len(vertex)) == 0
    # Two vertices may become one if their common neighbours are those in the faces between them.
    count = len(vertices)
    ends = np.concatenate([edges.ends, edges.ends[:, ::-1]])
    neighbour = coo_array((np.ones(len(ends), np.int32), ends.T), shape=(count, count)).tocsr()
    common = np.asarray((neighbour[vertex] * neighbour[target]).sum(axis=1)).ravel()
    valid &= common == np.bincount(move, vanishes, len(vertex))
    vertex, target = vertex[valid], target[valid]
    way = vertices[vertex] - vertices[target]
    distance = dots(way, way)
    order = np.lexsort((distance, vertex))
    _, nearest = np.unique(vertex[order], return_index=True)
    return vertex[order[nearest]], target[order[nearest]]
