# SPDX-License-Identifier: MIT
"""Pairs of shapes with known relations, to measure evidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from benchmarks.creatures import CREATURE_KINDS, make_creature
from shapegoogle_core.mesh import Mesh, unique_edges
from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.preprocessing.resampling import simplify
from shapegoogle_core.preprocessing.subdivision import subdivide

__all__ = ["EvidencePair", "cut", "make_pairs", "remeshed", "subdivided"]

# Offsets of the seeds of other individuals, beyond all seeds of queries.
_SIBLING, _STRANGER = 50_000, 70_000
# Vertices of a mesh that is made to be subdivided: the first number that leaves no edge between three faces.
_COARSE = range(300, 400, 10)


@dataclass(frozen=True, eq=False)
class EvidencePair:
    """A query, a candidate, and the true relation of the candidate to the query.

    Attributes
    ----------
    kind : str
        One of `shapegoogle_core.library.evidence.KINDS`.
    detail : str
        Construction of the candidate.
    query, candidate : Mesh
    factor : float
        Size of the candidate relative to the query.
    share : float
        Area of the smaller shape relative to the larger one if one is a part of the other; otherwise 1.
    """

    kind: str
    detail: str
    query: Mesh
    candidate: Mesh
    factor: float = 1.0
    share: float = 1.0


def make_pairs(creature: str, seed: int) -> list[EvidencePair]:
    """Make pairs of one procedural creature, at least one of each kind of evidence.

    Parameters
    ----------
    creature : str
        One of `CREATURE_KINDS`.
    seed : int
        Seed of the individual. The shipped models were trained on seeds 0 to 7.

    Returns
    -------
    pairs : list of EvidencePair
    """
    random = np.random.default_rng([seed, CREATURE_KINDS.index(creature)])
    individual = make_creature(creature, seed)
    poses = random.permutation(np.arange(1, 7))
    mesh, other = individual.pose(int(poses[0])), individual.pose(int(poses[1]))
    sibling = make_creature(creature, seed + _SIBLING).pose(int(poses[2]))
    stranger_kind = str(random.choice([kind for kind in CREATURE_KINDS if kind != creature]))
    stranger = make_creature(stranger_kind, seed + _STRANGER).pose(int(poses[2]))
    factor = float(np.exp(random.uniform(0.1, 1.6) * random.choice([-1, 1])))
    size = float(random.choice([1.0, random.uniform(0.3, 3)]))
    part = cut(mesh, random.normal(size=3), random.uniform(0.35, 0.85))
    share = part.area / mesh.area
    coarse = _base(mesh)
    reflected = Mesh(mesh.vertices * [-1, 1, 1], mesh.faces[:, ::-1].copy(), mesh.name)

    def pair(
        kind: str, detail: str, candidate: Mesh, factor: float = 1.0, share: float = 1.0
    ) -> EvidencePair:
        return EvidencePair(kind, detail, mesh, candidate, factor, share)

    return [
        pair("identical", "a copy", mesh),
        pair("identical", "other order of vertices and faces", _shuffled(mesh, random)),
        pair("moved", "moved", _moved(mesh, random)),
        pair("scaled", "moved and scaled", _moved(mesh, random, factor), factor),
        pair("mirrored", "reflected and moved", _moved(reflected, random)),
        pair("re-meshed", "other mesh, moved", _moved(remeshed(mesh, random), random, size), size),
        pair("re-meshed", "other mesh in place", remeshed(mesh, random)),
        pair("re-posed", "other pose", _moved(other, random, size), size),
        pair("re-posed", "other pose and mesh", _moved(remeshed(other, random), random)),
        pair("contains", "a part", _moved(part, random, size), size, share),
        EvidencePair("part of", "the whole", _moved(part, random), mesh, 1.0, share),
        EvidencePair("part of", "the whole, other mesh", remeshed(part, random), mesh, 1.0, share),
        pair("similar", "another individual of its kind", _moved(sibling, random)),
        pair("similar", "another kind", _moved(stranger, random)),
        # Last, so that the others are the same as before these were added.
        EvidencePair("version", "subdivided", coarse, _moved(subdivided(coarse), random)),
        EvidencePair("version", "the base of it", _moved(subdivided(coarse), random), coarse),
    ]


def _base(mesh: Mesh) -> Mesh:
    coarse = (simplify(mesh, count) for count in _COARSE)
    return next(base for base in coarse if unique_edges(base)[1].max() <= 2)


def subdivided(mesh: Mesh, levels: int = 2) -> Mesh:
    """Subdivide and smooth a mesh, as a subdivision modifier does.

    Parameters
    ----------
    mesh : Mesh
    levels : int, optional

    Returns
    -------
    smooth : Mesh
        By the method of Loop.
    """
    vertices, faces = trimesh.remesh.subdivide_loop(mesh.vertices, mesh.faces, levels)  # type: ignore[no-untyped-call]
    return Mesh(vertices, faces.astype(np.int32), mesh.name)


def _moved(mesh: Mesh, random: np.random.Generator, scale: float = 1.0) -> Mesh:
    turn = Rotation.random(random_state=int(random.integers(2**31))).as_matrix()
    shift = random.normal(size=3) * np.ptp(mesh.vertices, axis=0).max() * scale
    return Mesh(scale * mesh.vertices @ turn.T + shift, mesh.faces, mesh.name)


def _shuffled(mesh: Mesh, random: np.random.Generator) -> Mesh:
    order = random.permutation(len(mesh.vertices))
    faces = np.argsort(order)[mesh.faces][random.permutation(len(mesh.faces))]
    return Mesh(mesh.vertices[order], faces.astype(np.int32), mesh.name)


def remeshed(mesh: Mesh, random: np.random.Generator) -> Mesh:
    """Re-mesh a surface, with a third to twice the number of vertices.

    Parameters
    ----------
    mesh : Mesh
    random : numpy.random.Generator

    Returns
    -------
    other : Mesh
        Simplified, or with equal probability subdivided and then simplified, which moves all vertices.
    """
    count = len(mesh.vertices)
    if random.random() < 0.5:
        return simplify(mesh, int(count * random.uniform(0.35, 0.7)))
    return simplify(subdivide(mesh, 3 * count), int(count * random.uniform(0.8, 2)))


def cut(mesh: Mesh, direction: FloatArray, share: float) -> Mesh:
    """Keep a share of the area, on one side of a plane.

    Parameters
    ----------
    mesh : Mesh
    direction : (3,) array
        The part that lies farthest in this direction is removed.
    share : float
        From 0 to 1.

    Returns
    -------
    part : Mesh
    """
    order = np.argsort(mesh.vertices[mesh.faces].mean(axis=1) @ direction)
    areas = face_areas(mesh)[order]
    kept = order[np.cumsum(areas) <= share * areas.sum()]
    used, corners = np.unique(mesh.faces[kept], return_inverse=True)
    return Mesh(mesh.vertices[used], corners.reshape(-1, 3).astype(np.int32), mesh.name)
