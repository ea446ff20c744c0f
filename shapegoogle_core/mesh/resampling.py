# SPDX-License-Identifier: MIT
"""Bringing every shape to a working resolution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.mesh import Mesh
from shapegoogle_core.mesh.repair import repair

__all__ = ["resample", "simplify", "subdivide"]


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

    Parameters
    ----------
    mesh : Mesh
    budget : int

    Returns
    -------
    simplified : Mesh
        Repaired.
    """
    import fast_simplification

    while len(mesh.vertices) > budget:
        # A closed surface has twice as many faces as vertices, a soup fewer: keep the ratio that there is.
        target = int(len(mesh.faces) * budget / len(mesh.vertices))
        vertices, faces = fast_simplification.simplify(
            np.array(mesh.vertices), np.array(mesh.faces), target_count=target
        )
        simplified = repair(Mesh(vertices, faces, mesh.name))
        if len(simplified.faces) == 0 or len(simplified.vertices) > 0.98 * len(mesh.vertices):
            break  # nothing left that may be collapsed, as in a soup of separate triangles
        mesh = simplified
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

    # Two: a corner face, and a four-sided rest along its shorter diagonal. Opposite the first corner: the whole edge.
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
