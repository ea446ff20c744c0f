# SPDX-License-Identifier: MIT
"""Bringing every shape to a working resolution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import Mesh
from shapegoogle_core.mesh.repair import repair

__all__ = ["resample", "simplify", "subdivide"]

# fast_simplification compares quadric errors with fixed numbers, from 2e-6 to 1e5 squared units in a
# hundred rounds. On a mesh of unit size it would allow every collapse after a dozen rounds and ruin the
# shape (measured: 5 to 60 % of the area left on soup); on this diagonal the rounds go from 1e-7 to 0.04 of
# it.
SIMPLIFIED_DIAGONAL = 1e4
# Boundary vertices have no error of their own there, so sheets melt away from their outlines.
LEAST_KEPT_AREA = 0.9


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
    simplified = _collapse(mesh, budget, keep_boundary=True)
    if len(simplified.vertices) > budget:
        smaller = _collapse(simplified, budget, keep_boundary=False)
        if smaller.area >= LEAST_KEPT_AREA * simplified.area:
            simplified = smaller
    return simplified


def _collapse(mesh: Mesh, budget: int, keep_boundary: bool) -> Mesh:
    import fast_simplification

    while len(mesh.vertices) > budget:
        origin = mesh.vertices.min(axis=0)
        unit = np.linalg.norm(np.ptp(mesh.vertices, axis=0)) / SIMPLIFIED_DIAGONAL
        # A closed surface has twice as many faces as vertices, a soup fewer: keep the ratio that there is.
        target = int(len(mesh.faces) * budget / len(mesh.vertices))
        vertices, faces = fast_simplification.simplify(
            (mesh.vertices - origin) / unit,
            np.array(mesh.faces),
            target_count=target,
            preserve_border=keep_boundary,
        )
        simplified = repair(Mesh(vertices * unit + origin, faces, mesh.name))
        stuck = len(faces) > 1.01 * target or len(simplified.vertices) >= len(mesh.vertices)
        if len(simplified.faces) == 0:
            break
        mesh = simplified
        if stuck:
            break  # all rounds are through; another run would only allow larger errors
    return mesh


def subdivide(mesh: Mesh, floor: int) -> Mesh:
    """Split the longest edges at their midpoints until there are `floor` vertices.

    Every face of a split edge is split there, so the surface stays as it is, point by point, and stays
    connected; long thin triangles become even ones.

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
    while len(mesh.vertices) < floor:
        edges, edge_of_side = _edges(mesh)
        length = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
        missing = floor - len(mesh.vertices)
        # Halves of an edge may be longer than another whole one: go down to half the longest in one round.
        # Edges of the same length go together, so that the result does not depend on rounding.
        least = np.partition(length, -missing)[-missing] if missing < len(length) else 0.0
        mesh = _split(mesh, edges, edge_of_side, length >= (1 - 1e-6) * max(least, 0.5 * length.max()))
    return mesh


def _edges(mesh: Mesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Undirected edges, (e, 2), and for each face the edges opposite its corners, (m, 3)."""
    sides = np.sort(mesh.faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2).astype(np.int64), axis=1)
    keys, edge = np.unique(sides[:, 0] * len(mesh.vertices) + sides[:, 1], return_inverse=True)
    return np.stack(np.divmod(keys, len(mesh.vertices)), axis=1), edge.reshape(-1, 3)


def _split(
    mesh: Mesh, edges: NDArray[np.int64], edge_of_side: NDArray[np.int64], chosen: NDArray[np.bool_]
) -> Mesh:
    """Split the chosen edges and with them all their faces."""
    midpoints = mesh.vertices[edges[chosen]].mean(axis=1)
    vertices = np.concatenate([mesh.vertices, midpoints])
    midpoint_of_edge = np.full(len(edges), -1)
    midpoint_of_edge[chosen] = len(mesh.vertices) + np.arange(len(midpoints))
    midpoint = midpoint_of_edge[edge_of_side]  # opposite each corner; -1: not split
    count = (midpoint >= 0).sum(axis=1)
    faces = [mesh.faces[count == 0].astype(np.int64)]

    # One edge split: two faces. Turn the faces so that the split edge lies opposite the first corner.
    turned = np.argmax(midpoint >= 0, axis=1)
    (a, b, c), (ma, _, _) = _turn(mesh.faces, midpoint, turned, count == 1)
    faces += [np.stack([a, b, ma], axis=1), np.stack([a, ma, c], axis=1)]

    # Two: a corner face, and a four-sided rest along its shorter diagonal. Opposite the first corner: the
    # whole edge.
    turned = np.argmax(midpoint < 0, axis=1)
    (a, b, c), (_, mb, mc) = _turn(mesh.faces, midpoint, turned, count == 2)
    to_b = np.linalg.norm(vertices[mb] - vertices[b], axis=1) <= np.linalg.norm(
        vertices[mc] - vertices[c], axis=1
    )
    faces += [
        np.stack([a, mc, mb], axis=1),
        np.stack([mc, b, np.where(to_b, mb, c)], axis=1),
        np.stack([np.where(to_b, b, mc), c, mb], axis=1),
    ]

    # Three: four faces.
    (a, b, c), (ma, mb, mc) = _turn(mesh.faces, midpoint, turned, count == 3)
    faces += [np.stack(corners, axis=1) for corners in ((a, mc, mb), (mc, b, ma), (mb, ma, c), (ma, mb, mc))]
    return Mesh(vertices, np.concatenate(faces), mesh.name)


def _turn(
    faces: NDArray[np.int32], midpoint: NDArray[np.int64], first: NDArray[np.int64], which: NDArray[np.bool_]
) -> tuple[tuple[NDArray[np.int64], ...], tuple[NDArray[np.int64], ...]]:
    """Corners and midpoints opposite them of some faces, turned so that corner `first` comes first."""
    rows = np.flatnonzero(which)
    order = (first[rows, None] + np.arange(3)) % 3
    corners = faces[rows[:, None], order].astype(np.int64)
    return tuple(corners.T), tuple(midpoint[rows[:, None], order].T)
