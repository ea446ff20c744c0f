# SPDX-License-Identifier: MIT
"""The same surface, cut into other triangles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.preprocessing.flat_regions import flat_regions
from shapegoogle_core.preprocessing.subdivision import subdivide
from shapegoogle_core.preprocessing.triangulation import edge_table

__all__ = ["flipped", "reordered", "split_in_four", "tessellations"]

FLIP_ROUNDS = 4
LEAST_TURN = 1e-3


def tessellations(mesh: Mesh, random: np.random.Generator) -> Iterator[tuple[str, Mesh]]:
    """Cut a surface into other triangles; the surface stays the same, point by point.

    Parameters
    ----------
    mesh : Mesh
        Repaired.
    random : numpy.random.Generator

    Yields
    ------
    name : str
        Construction.
    mesh : Mesh
    """
    yield "facets in another order", reordered(mesh, random)
    yield "diagonals flipped at random", flipped(mesh, random)
    yield "split in four", split_in_four(mesh)
    yield "split in sixteen", split_in_four(split_in_four(mesh))
    yield "even triangles", subdivide(mesh, 4 * len(mesh.vertices) + 400)
    yield "diagonals flipped, split", reordered(split_in_four(flipped(mesh, random)), random)


def split_in_four(mesh: Mesh) -> Mesh:
    """Split every face at the midpoints of its edges.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    split : Mesh
    """
    import trimesh

    vertices, faces = trimesh.remesh.subdivide(mesh.vertices, mesh.faces)  # type: ignore[no-untyped-call]
    return Mesh(vertices, faces, mesh.name)


def reordered(mesh: Mesh, random: np.random.Generator) -> Mesh:
    """Give vertices and faces another order.

    Parameters
    ----------
    mesh : Mesh
    random : numpy.random.Generator

    Returns
    -------
    reordered : Mesh
    """
    order = random.permutation(len(mesh.vertices))
    faces = np.argsort(order)[mesh.faces][random.permutation(len(mesh.faces))]
    return Mesh(mesh.vertices[order], faces.astype(np.int32), mesh.name)


def flipped(mesh: Mesh, random: np.random.Generator) -> Mesh:
    """Flip edges between faces in one plane at random.

    Parameters
    ----------
    mesh : Mesh
        Repaired.
    random : numpy.random.Generator

    Returns
    -------
    flipped : Mesh
    """
    region = flat_regions(mesh)
    faces = mesh.faces.astype(np.int64)
    for _ in range(FLIP_ROUNDS):
        edges = edge_table(faces)
        known = set(map(tuple, edges.ends.tolist()))
        touched = np.zeros(len(faces), bool)
        for edge in random.permutation(np.flatnonzero(edges.inside(region))).tolist():
            one, other = int(edges.first[edge]), int(edges.last[edge])
            if touched[one // 3] or touched[other // 3]:
                continue
            p, i, j = (int(faces[one // 3, (one % 3 + step) % 3]) for step in range(3))
            q = int(faces[other // 3, other % 3])
            if (min(p, q), max(p, q)) in known or not _is_convex(mesh.vertices[[p, i, q, j]]):
                continue
            known.add((min(p, q), max(p, q)))
            faces[one // 3], faces[other // 3] = (p, i, q), (q, j, p)
            touched[[one // 3, other // 3]] = True
    return Mesh(mesh.vertices, faces.astype(np.int32), mesh.name)


def _is_convex(corners: FloatArray) -> bool:
    """Whether a flat quadrilateral is convex, and neither of its halves low."""
    side = np.roll(corners, -1, axis=0) - corners
    turn = np.cross(side, np.roll(side, -1, axis=0))
    normal = turn.sum(axis=0)
    least = LEAST_TURN * float((side**2).sum())
    return bool((turn @ normal > least * np.linalg.norm(normal)).all())
