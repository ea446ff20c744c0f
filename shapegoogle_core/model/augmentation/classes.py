# SPDX-License-Identifier: MIT
"""The transformation classes of SHREC 2010 in five strengths (paper, section 6.1), made from any mesh."""

from __future__ import annotations

import zlib
from collections.abc import Callable

import fast_simplification
import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, check_surface
from shapegoogle_core.mesh.connectivity import edge_graph, edge_lengths
from shapegoogle_core.mesh.measures import vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["TRANSFORMATIONS", "scale_factor", "transform"]

BoolArray = NDArray[np.bool_]
Random = np.random.Generator

_SCALES = (0.5, 0.875, 1.25, 1.625, 2.0)
_FACE_SHARES = (0.50, 0.35, 0.25, 0.20, 0.15)
_BUMPS = 3
# Places to weld are searched at this many random vertices, each with the nearest one that is far along the
# surface.
_WELD_CANDIDATES = 64


def transform(mesh: Mesh, kind: str, strength: int, seed: int) -> Mesh:
    """Transform a mesh as the SHREC 2010 benchmark does (paper, section 6.1).

    With e the mean edge length, D the diagonal of the bounding box and s the strength:

    ============ ==========================================================================================
    noise        every coordinate of every vertex + N(0, (0.1 s e)²)
    shot_noise   0.2 s % of the vertices + N(0, (4 e)²) per coordinate
    micro_holes  0.5 s % of the vertices removed with their faces
    holes        2 s balls of radius 0.03 D, centred on random vertices, cut out
    topology     3 s welds of two vertices close in space and at least 0.35 D apart along the surface
    scale        by 0.5, 0.875, 1.25, 1.625, 2
    local_scale  three Gaussian bumps (σ = 0.12 D) pushed along the normal by 0.008 s D
    sampling     simplified to 50, 35, 25, 20, 15 % of the faces
    partial      a random half-space takes (5 + 5 s) % of the vertices, then s balls of radius 0.06 D
    mixed        noise, holes and scale together at strength max(1, s − 1)
    ============ ==========================================================================================

    The same seed chooses the same places at every strength, so that a stronger transformation continues a
    weaker one.

    Parameters
    ----------
    mesh : Mesh
        Any triangles, including polygon soup. It is not changed.
    kind : str
        One of `TRANSFORMATIONS`.
    strength : int
        From 1 to 5.
    seed : int

    Returns
    -------
    transformed : Mesh
        Named after the mesh, the kind and the strength. Where faces were removed, it has no loose vertices.

    Raises
    ------
    ValueError
        If the kind or the strength does not exist.
    MeshError
        If the mesh has no surface (see `check_surface`), or this transformation cannot be applied to it.
    """
    if kind not in _FUNCTIONS:
        raise ValueError(f"no transformation {kind!r}; there are {', '.join(TRANSFORMATIONS)}")
    if strength not in (1, 2, 3, 4, 5):
        raise ValueError(f"strength must be 1 … 5, not {strength}")
    check_surface(mesh)
    rng = np.random.default_rng([zlib.crc32(kind.encode()), seed])
    transformed = _FUNCTIONS[kind](mesh, strength, rng)
    return Mesh(transformed.vertices, transformed.faces, f"{mesh.name}-{kind}-{strength}")


def _diagonal(mesh: Mesh) -> float:
    """Return the length of the diagonal of the bounding box of the faces."""
    return float(np.linalg.norm(np.ptp(mesh.vertices[np.unique(mesh.faces)], axis=0)))


def _noise(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    deviation = 0.1 * strength * edge_lengths(mesh).mean()
    return Mesh(mesh.vertices + deviation * _per_place(mesh, rng), mesh.faces, mesh.name)


def _per_place(mesh: Mesh, rng: Random) -> FloatArray:
    """Draw standard normal vectors for the vertices; duplicates get the same, or polygon soup would tear."""
    _, place = _places(mesh)
    return rng.standard_normal((place.max() + 1, 3))[place]


def _places(mesh: Mesh) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return distinct positions of the vertices in order of appearance, and the position number of each."""
    _, first, place = np.unique(mesh.vertices, axis=0, return_index=True, return_inverse=True)
    order = first.argsort()
    return mesh.vertices[first[order]], order.argsort()[place.reshape(-1)]


def _shot_noise(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    shifts = 4 * edge_lengths(mesh).mean() * _per_place(mesh, rng)
    hit = _share_of_places(mesh, 0.002 * strength, rng)
    return Mesh(mesh.vertices + hit[:, None] * shifts, mesh.faces, mesh.name)


def _share_of_places(mesh: Mesh, share: float, rng: Random) -> BoolArray:
    """Return a mask of the vertices at a random share of the distinct positions, at least at one."""
    positions, place = _places(mesh)
    rank = rng.permutation(len(positions))
    return np.less(rank[place], max(1, round(share * len(positions))))


def _micro_holes(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    return _without(mesh, _share_of_places(mesh, 0.005 * strength, rng), "micro_holes")


def _holes(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    return _without(mesh, _in_balls(mesh, 2 * strength, 0.03 * _diagonal(mesh), rng), "holes")


def _in_balls(mesh: Mesh, count: int, radius: float, rng: Random) -> BoolArray:
    """Return a mask of the vertices inside balls around random vertices."""
    used = np.unique(mesh.faces)
    centres = mesh.vertices[rng.permutation(used)[:count]]
    distances, _ = cKDTree(centres).query(mesh.vertices)
    return np.less_equal(distances, radius)


def _without(mesh: Mesh, removed: BoolArray, kind: str) -> Mesh:
    """Return the mesh without these vertices, their faces and all loose vertices."""
    faces = mesh.faces[~removed[mesh.faces].any(axis=1)]
    if len(faces) == 0:
        raise MeshError(
            f"{mesh.name!r}: {kind} leaves none of its {len(mesh.faces)} faces; the mesh is too coarse for it"
        )
    return _compact(mesh.vertices, faces, mesh.name)


def _compact(vertices: FloatArray, faces: NDArray[np.int32], name: str) -> Mesh:
    used, corners = np.unique(faces, return_inverse=True)
    return Mesh(vertices[used], corners.reshape(-1, 3), name)


def _topology(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    # Duplicate vertices count as one, so that the surface of polygon soup continues across its seams.
    positions, place = _places(mesh)
    joined = Mesh(positions, place[mesh.faces], mesh.name)
    wanted = 3 * strength
    pairs = _places_to_weld(joined, 0.35 * _diagonal(mesh), rng)[:wanted]
    if len(pairs) < wanted:
        raise MeshError(
            f"{mesh.name!r} has only {len(pairs)} places where surfaces far apart come near each other, but "
            f"topology {strength} welds {wanted}; take a finer mesh or a lower strength"
        )
    moved = positions.copy()
    moved[pairs] = positions[pairs].mean(axis=1, keepdims=True)
    merged = np.arange(len(positions))
    merged[pairs[:, 1]] = pairs[:, 0]
    # Each vertex of the result is a vertex of the mesh, or two welded ones.
    target = np.arange(len(mesh.vertices))
    first_at_place = np.full(len(positions), len(mesh.vertices))
    np.minimum.at(first_at_place, place, target)
    welded = np.isin(place, pairs)
    target[welded] = first_at_place[merged[place[welded]]]
    faces = target[mesh.faces]
    distinct = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return _compact(moved[place], faces[distinct].astype(np.int32), mesh.name)


def _places_to_weld(mesh: Mesh, apart: float, rng: Random) -> NDArray[np.int64]:
    """Find disjoint pairs of vertices, nearest in space first, that are at least `apart` along the edges."""
    used = np.unique(mesh.faces)
    sources = rng.permutation(used)[:_WELD_CANDIDATES]
    # Distances beyond the limit are infinite, which is all that matters.
    along = dijkstra(edge_graph(mesh), directed=False, indices=sources, limit=apart)[:, used]
    across = np.linalg.norm(mesh.vertices[sources][:, None] - mesh.vertices[used][None], axis=2)
    across[along < apart] = np.inf
    nearest = across.argmin(axis=1)
    gaps = across[np.arange(len(sources)), nearest]
    pairs: list[tuple[int, int]] = []
    taken: set[int] = set()
    for candidate in gaps.argsort(kind="stable"):
        pair = int(sources[candidate]), int(used[nearest[candidate]])
        if np.isfinite(gaps[candidate]) and taken.isdisjoint(pair):
            pairs.append(pair)
            taken.update(pair)
    return np.array(pairs, np.int64).reshape(-1, 2)


def _scale(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    del rng  # deterministic
    return Mesh(mesh.vertices * _SCALES[strength - 1], mesh.faces, mesh.name)


def scale_factor(kind: str, strength: int) -> float:
    """Return the factor by which `transform` enlarges a shape.

    Parameters
    ----------
    kind : str
        One of `TRANSFORMATIONS`.
    strength : int
        From 1 to 5.

    Returns
    -------
    factor : float
        1 for all but "scale" and "mixed".
    """
    factors = {"scale": _SCALES[strength - 1], "mixed": _SCALES[_mixed_strength(strength) - 1]}
    return factors.get(kind, 1.0)


def _local_scale(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    diagonal = _diagonal(mesh)
    centres = mesh.vertices[rng.permutation(np.unique(mesh.faces))[:_BUMPS]]
    squared = ((mesh.vertices[:, None] - centres[None]) ** 2).sum(axis=2)
    height = np.exp(-squared / (2 * (0.12 * diagonal) ** 2)).sum(axis=1)
    push = 0.008 * strength * diagonal * height
    return Mesh(mesh.vertices + push[:, None] * _normals(mesh), mesh.faces, mesh.name)


def _normals(mesh: Mesh) -> FloatArray:
    """Compute unit normals of the vertices; duplicates get the same, and 0 where faces cancel out."""
    positions, place = _places(mesh)
    return vertex_normals(Mesh(positions, place[mesh.faces].astype(np.int32)))[place]


def _sampling(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    del rng  # deterministic
    wanted = round(_FACE_SHARES[strength - 1] * len(mesh.faces))
    if max(wanted, 4) >= len(mesh.faces):
        raise MeshError(
            f"{mesh.name!r} has only {len(mesh.faces)} faces, too few to sample; take a finer mesh"
        )
    positions, place = _places(mesh)
    vertices, faces = fast_simplification.simplify(
        positions.copy(), place[mesh.faces].astype(np.int32), target_count=max(wanted, 4)
    )
    if len(faces) > 1.02 * wanted:
        # Edge collapse keeps the borders of polygon soup and stops early, so the rest is merged by position.
        vertices, faces = _clustered(vertices, faces, wanted)
    if len(faces) == 0:
        raise MeshError(
            f"{mesh.name!r}: sampling {strength} leaves {wanted} of its {len(mesh.faces)} faces, "
            "too few for a shape; take a finer mesh"
        )
    return _compact(np.asarray(vertices, np.float64), faces, mesh.name)


def _clustered(
    vertices: FloatArray, faces: NDArray[np.int32], wanted: int
) -> tuple[FloatArray, NDArray[np.int32]]:
    """Merge the vertices in each cell of a grid, the finest one that leaves at most `wanted` faces."""
    low = vertices.min(axis=0)
    finest, coarsest = 0.0, float(np.ptp(vertices, axis=0).max()) + np.finfo(float).tiny
    best = vertices[:0], faces[:0]
    for _ in range(20):
        cell = (finest + coarsest) / 2
        _, cluster, counts = np.unique(
            np.floor((vertices - low) / cell), axis=0, return_inverse=True, return_counts=True
        )
        cluster = cluster.reshape(-1)
        merged = cluster[faces]
        merged = merged[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
        _, first = np.unique(np.sort(merged, axis=1), axis=0, return_index=True)
        if len(first) > wanted:
            finest = cell
            continue
        coarsest = cell
        if len(first) > len(best[1]):
            sums = [np.bincount(cluster, vertices[:, axis]) for axis in range(3)]
            best = np.stack(sums, axis=1) / counts[:, None], merged[first].astype(np.int32)
    return best


def _partial(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    diagonal = _diagonal(mesh)
    depth = mesh.vertices @ rng.standard_normal(3)
    beyond = depth > np.quantile(depth[np.unique(mesh.faces)], 1 - (0.05 + 0.05 * strength))
    rest = _without(mesh, beyond, "partial")
    return _without(rest, _in_balls(rest, strength, 0.06 * diagonal, rng), "partial")


def _mixed(mesh: Mesh, strength: int, rng: Random) -> Mesh:
    for step in (_noise, _holes, _scale):
        mesh = step(mesh, _mixed_strength(strength), rng)
    return mesh


def _mixed_strength(strength: int) -> int:
    return max(1, strength - 1)


_FUNCTIONS: dict[str, Callable[[Mesh, int, Random], Mesh]] = {
    "noise": _noise,
    "shot_noise": _shot_noise,
    "micro_holes": _micro_holes,
    "holes": _holes,
    "topology": _topology,
    "scale": _scale,
    "local_scale": _local_scale,
    "sampling": _sampling,
    "partial": _partial,
    "mixed": _mixed,
}

TRANSFORMATIONS: tuple[str, ...] = tuple(_FUNCTIONS)
"""Kinds of `transform`."""
