# SPDX-License-Identifier: MIT
"""Bringing every shape to a working resolution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.mesh.repair import repair

__all__ = ["resample", "simplify", "subdivide"]

# fast_simplification compares quadric errors with fixed numbers, from 2e-6 to 1e5 squared units in a
# hundred rounds. On a mesh of unit size it would allow every collapse after a dozen rounds and ruin the
# shape (measured: 5 to 60 % of the area left on soup); on this diagonal the rounds go from 1e-7 to 0.04 of
# it.
SIMPLIFIED_DIAGONAL = 1e4
# Boundary vertices have no error of their own there, so sheets melt away from their outlines.
LEAST_KEPT_AREA = 0.9

# New edges inside an old face are split later than its sides, so that a thin face becomes a zigzag between
# points on its sides; without that (and flips) it would become ever thinner faces.
INNER_EDGE = 1.5
LEAST_OF_ROUND = 0.75
FLIP_TOLERANCE = 1e-9
MOST_FLIP_ROUNDS = 100  # ends sooner but for rounding

Indices = NDArray[np.int64]


def resample(mesh: Mesh, floor: int = 1000, budget: int = 5000) -> Mesh:
    """Simplify a mesh above the budget of vertices, subdivide one below the floor.

    Parameters
    ----------
    mesh : Mesh
        Repaired.
    floor : int, optional
        Fewest vertices wanted; see `subdivide`.
    budget : int, optional
        Most vertices wanted; see `simplify`.

    Returns
    -------
    resampled : Mesh
    """
    if len(mesh.vertices) > budget:
        mesh = simplify(mesh, budget)
    if len(mesh.vertices) < floor:
        mesh = subdivide(mesh, floor)
    return mesh


def simplify(mesh: Mesh, budget: int) -> Mesh:
    """Collapse edges by quadric error until there are no more than `budget` vertices, where that can be had.

    Open boundaries are kept first; if that leaves too many vertices, they are given up too unless more than a
    tenth of the area would go with them. Polygon soup of many small sheets therefore stays above the budget:
    fewer vertices would mean another shape.

    Parameters
    ----------
    mesh : Mesh
    budget : int

    Returns
    -------
    simplified : Mesh
        Repaired.
    """
    first = True  # may lose any area: that of noise, for one
    for keep_boundary in (True, False):
        exhausted = False
        while len(mesh.vertices) > budget and not exhausted:
            # A closed surface has twice as many faces as vertices, a soup fewer: keep the ratio.
            target = int(len(mesh.faces) * budget / len(mesh.vertices))
            simplified = _collapse(mesh, target, keep_boundary)
            if len(simplified.faces) == 0 or (not first and simplified.area < LEAST_KEPT_AREA * mesh.area):
                break
            # Once all rounds are through, another run would only allow larger errors.
            exhausted = len(simplified.faces) > 1.01 * target or len(simplified.vertices) == len(
                mesh.vertices
            )
            mesh, first = simplified, False
    return mesh


def _collapse(mesh: Mesh, face_count: int, keep_boundary: bool) -> Mesh:
    import fast_simplification

    origin = mesh.vertices.min(axis=0)
    unit = np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / SIMPLIFIED_DIAGONAL
    vertices, faces = fast_simplification.simplify(
        (mesh.vertices - origin) / unit,
        np.array(mesh.faces),
        target_count=face_count,
        preserve_border=keep_boundary,
    )
    return repair(Mesh(vertices * unit + origin, faces, mesh.name))


def subdivide(mesh: Mesh, floor: int) -> Mesh:
    """Split long edges at their midpoints until there are `floor` vertices.

    Every face of a split edge is split there, and within the old faces, which are flat, edges are flipped to
    make the triangles as even as can be (Delaunay). So the surface stays as it is, point by point, and stays
    connected, and long thin faces become even ones.

    Parameters
    ----------
    mesh : Mesh
        With faces.
    floor : int

    Returns
    -------
    subdivided : Mesh
        The same vertices first. A few more than `floor` where edges of the same length are split together.
    """
    vertices, faces = mesh.vertices, mesh.faces.astype(np.int64)
    parent = np.arange(len(faces))
    while len(vertices) < floor:
        edges, edge_of_side, inner = _edges(faces, parent)
        length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
        length[inner] /= INNER_EDGE
        missing = floor - len(vertices)
        # Not all at once: splitting and flipping leave other edges. Edges of the same length go together, so
        # that the result does not depend on rounding.
        least = np.partition(length, -missing)[-missing] if missing < len(length) else 0.0
        chosen = length >= (1 - 1e-6) * max(least, LEAST_OF_ROUND * length.max())
        vertices, faces, parent = _split(vertices, faces, parent, edges, edge_of_side, chosen)
        faces = _flip(vertices, faces, parent)
    return mesh if len(vertices) == len(mesh.vertices) else Mesh(vertices, faces, mesh.name)


def _edges(faces: Indices, parent: Indices) -> tuple[Indices, Indices, NDArray[np.bool_]]:
    """Edges, (e, 2), for each face those opposite its corners, (m, 3), and which lie inside an old face."""
    sides = np.sort(faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
    count = int(faces.max()) + 1
    keys, first, edge = np.unique(sides[:, 0] * count + sides[:, 1], return_index=True, return_inverse=True)
    edge = edge.reshape(-1, 3)
    last = np.empty(len(keys), np.int64)
    last[edge.ravel()] = np.arange(edge.size)
    inner = (first != last) & (parent[first // 3] == parent[last // 3])
    return np.stack(np.divmod(keys, count), axis=1), edge, inner


def _split(
    vertices: FloatArray,
    faces: Indices,
    parent: Indices,
    edges: Indices,
    edge_of_side: Indices,
    chosen: NDArray[np.bool_],
) -> tuple[FloatArray, Indices, Indices]:
    """Split the chosen edges and with them all their faces; new faces take the parents of old ones."""
    midpoints = vertices[edges[chosen]].mean(axis=1)
    midpoint_of_edge = np.full(len(edges), -1)
    midpoint_of_edge[chosen] = len(vertices) + np.arange(len(midpoints))
    vertices = np.concatenate([vertices, midpoints])
    midpoint = midpoint_of_edge[edge_of_side]  # opposite each corner; -1: not split
    count = (midpoint >= 0).sum(axis=1)
    new_faces, new_parents = [faces[count == 0]], [parent[count == 0]]

    def add(which: NDArray[np.bool_], *corners: tuple[Indices, Indices, Indices]) -> None:
        new_faces.extend(np.stack(each, axis=1) for each in corners)
        new_parents.extend([parent[which]] * len(corners))

    # One edge split: two faces. Turned so that the split edge lies opposite the first corner.
    a, b, c, ma, _, _ = _turn(faces, midpoint, np.argmax(midpoint >= 0, axis=1), count == 1)
    add(count == 1, (a, b, ma), (a, ma, c))
    # Two: a corner, and the rest along one of its diagonals. Opposite the first corner: the whole edge.
    whole = np.argmax(midpoint < 0, axis=1)
    a, b, c, _, mb, mc = _turn(faces, midpoint, whole, count == 2)
    add(count == 2, (a, mc, mb), (mc, b, mb), (b, c, mb))
    # Three: four faces.
    a, b, c, ma, mb, mc = _turn(faces, midpoint, whole, count == 3)
    add(count == 3, (a, mc, mb), (mc, b, ma), (mb, ma, c), (ma, mb, mc))
    return vertices, np.concatenate(new_faces), np.concatenate(new_parents)


def _turn(faces: Indices, midpoint: Indices, first: Indices, which: NDArray[np.bool_]) -> Indices:
    """Corners of some faces and the midpoints opposite, (6, k), turned so that corner `first` comes first."""
    rows = np.flatnonzero(which)[:, None]
    order = (first[rows] + np.arange(3)) % 3
    return np.concatenate([faces[rows, order], midpoint[rows, order]], axis=1).T


def _flip(vertices: FloatArray, faces: Indices, parent: Indices) -> Indices:
    """Flip edges inside old faces until every triangle is Delaunay in its plane (Lawson 1977)."""
    faces = faces.copy()
    for _ in range(MOST_FLIP_ROUNDS):
        _, edge_of_side, inner = _edges(faces, parent)
        order = np.argsort(edge_of_side.ravel(), kind="stable")
        order = order[inner[edge_of_side.ravel()[order]]]
        one, other = order[0::2], order[1::2]  # the two sides of each inner edge
        cotangents = _opposite_cotangents(vertices, faces)
        total = cotangents.ravel()[one] + cotangents.ravel()[other]
        # Each face takes part in its most urgent flip only, and only if its neighbour's is the same.
        urgent = np.flatnonzero(total < -FLIP_TOLERANCE)
        urgent = urgent[np.argsort(total[urgent], kind="stable")]
        if len(urgent) == 0:
            break
        best = np.full(len(faces), len(urgent))
        rank = np.arange(len(urgent))
        np.minimum.at(best, one[urgent] // 3, rank)
        np.minimum.at(best, other[urgent] // 3, rank)
        agreed = (best[one[urgent] // 3] == rank) & (best[other[urgent] // 3] == rank)
        one, other = one[urgent[agreed]], other[urgent[agreed]]
        p, i, j = (faces[one // 3, (one % 3 + step) % 3] for step in range(3))
        q = faces[other // 3, other % 3]
        faces[one // 3] = np.stack([p, i, q], axis=1)
        faces[other // 3] = np.stack([q, j, p], axis=1)
    return faces


def _opposite_cotangents(vertices: FloatArray, faces: Indices) -> FloatArray:
    """Cotangent of the angle at each corner, (m, 3)."""
    corners = vertices[faces]
    to_next = np.roll(corners, -1, axis=1) - corners
    to_last = np.roll(corners, 1, axis=1) - corners
    double_area = np.linalg.norm(np.cross(to_next[:, 0], to_last[:, 0]), axis=1)
    # A face without area has the cotangents of a very low one.
    longest = np.linalg.norm(to_next, axis=2).max(axis=1)
    cotangents: FloatArray = (to_next * to_last).sum(axis=2) / np.maximum(double_area, 1e-12 * longest**2)[
        :, None
    ]
    return cotangents
