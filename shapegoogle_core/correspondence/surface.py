# SPDX-License-Identifier: MIT
"""A shape ready to be matched: a clean, connected copy of working resolution and what is known on it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order, connected_components, dijkstra
from scipy.spatial import KDTree

from shapegoogle_core.descriptors import log_heat_kernel_signature, wave_kernel_signature
from shapegoogle_core.laplacian import Operator, build_operator
from shapegoogle_core.mesh.checks import check_surface
from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh
from shapegoogle_core.mesh.prolongation import vertex_prolongation
from shapegoogle_core.preprocessing import repair_mapped, resample
from shapegoogle_core.registration.sample import farthest_points
from shapegoogle_core.spectral import Spectrum, operator_spectrum

__all__ = ["SurfaceSettings", "WorkingSurface", "distance_graph", "working_surface"]

Indices = NDArray[np.int64]

# All lengths are in units of √area, all times in units of the area.
# Loose parts beyond these, the smallest, are left out: their vertices take what lies nearest.
_MOST_PARTS = 64
# A part is tied to the rest at all its vertices that are so much farther off than its nearest one, at most.
_TIE_REACH, _MOST_TIES = 0.02, 30
_HEAT_TIMES = np.geomspace(0.005, 0.3, 8)
# Weyl: the k-th eigenvalue of a surface of unit area is about 4πk. The same energies for all shapes.
_WAVE_ENERGIES = np.linspace(math.log(15), math.log(1000), 24)
_WAVE_SIGMA = 7 * float(_WAVE_ENERGIES[1] - _WAVE_ENERGIES[0])
# A point is a tip if none within this distance is farther from the rest of the shape.
_TIP_RADIUS = 0.12
_MOST_TIPS = 12
# A closed surface of unit area holds at most 1/(6√π) = 0.094; less than this share of it says nothing.
_LEAST_VOLUME = 1e-3


@dataclass(frozen=True)
class SurfaceSettings:
    """How fine the copies are on which shapes are matched.

    Parameters
    ----------
    floor, budget : int
        Fewest and most vertices.
    eigenpairs : int
        Size of the final functional map.
    samples : int
        How many points the map is refined on.
    compared : int
        How many of these candidates are compared on; the distances of each to all others are computed.
    """

    floor: int = 1000
    budget: int = 3000
    eigenpairs: int = 120
    samples: int = 1000
    compared: int = 300


@dataclass(frozen=True, eq=False)
class WorkingSurface:
    """A clean copy of a mesh, scaled to unit area.

    Attributes
    ----------
    mesh : Mesh
        The copy, with n vertices.
    whole : Mesh
        The mesh as given, repaired, in the place and scale of the copy.
    whole_faces : (M,) array of int
        Which face of the mesh as given each face of `whole` is.
    spectrum : Spectrum
        Of the copy; its loose parts are tied together, so that only the first eigenvalue is 0.
    prolongation : (N, n) sparse array
        Carries values to the vertices of the mesh as given; rows of vertices that no face uses are empty.
    scale : float
        Length of a unit of the copy in the unit of the mesh: its √area.
    normals : (n, 3) array
        Area-weighted, of the faces turned the same way; outwards where that can be told. Zero where faces
        cannot be turned the same way.
    faces : (m, 3) array of int
        Those of the copy, turned the same way.
    outward : bool
        Whether the surface encloses a volume, so that inside and outside are known.
    samples : (s,) array of int
        Vertices spread evenly; each first part of them is.
    distances : (n, c) array
        Along the surface from all vertices to the first c samples.
    graph : (n, n) sparse array
        What distances are measured along, see `distance_graph`.
    tips : (t,) array of int
        Positions in `samples` of extremities, the farthest first.
    descriptors : (n, d) array
        Heat and wave kernel signatures, in units of their spread over the surface.
    """

    mesh: Mesh
    whole: Mesh
    whole_faces: Indices
    spectrum: Spectrum
    prolongation: sparse.csr_array
    scale: float
    normals: FloatArray
    faces: IntArray
    outward: bool
    samples: Indices
    distances: FloatArray
    graph: sparse.csr_array
    tips: Indices
    descriptors: FloatArray

    @property
    def compared(self) -> Indices:
        """(c,) vertices to which distances are known."""
        return self.samples[: self.distances.shape[1]]

    def distances_to(self, vertices: Indices) -> FloatArray:
        """(n, len(vertices)) distances along the surface from all vertices to some."""
        sources, place = np.unique(vertices, return_inverse=True)
        along: FloatArray = dijkstra(self.graph, directed=False, indices=sources)[place].T
        return along

    @property
    def waves(self) -> FloatArray:
        """(n, d) wave kernel signatures among the descriptors."""
        return self.descriptors[:, len(_HEAT_TIMES) :]

    @cached_property
    def apart(self) -> FloatArray:
        """(c, c) distances between them."""
        return self.distances[self.compared]

    @cached_property
    def coordinates(self) -> FloatArray:
        """(k, 6) coefficients of the positions and the normals in the eigenfunctions."""
        values = np.concatenate([self.mesh.vertices, self.normals], axis=1)
        coefficients: FloatArray = (self.spectrum.eigenvectors.T * self.spectrum.mass) @ values
        return coefficients


def working_surface(mesh: Mesh, settings: SurfaceSettings) -> WorkingSurface:
    """Prepare a mesh for matching.

    Parameters
    ----------
    mesh : Mesh
        Of any resolution, also open or in several parts.
    settings : SurfaceSettings

    Returns
    -------
    surface : WorkingSurface

    Raises
    ------
    MeshError
        If the mesh has no surface, or its eigenproblem cannot be solved.
    """
    check_surface(mesh)
    # To unit size first: squares of very small or very large coordinates would leave the range of floats.
    used = mesh.vertices[np.unique(mesh.faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    size = float(np.linalg.norm(high - low))
    centered = Mesh((mesh.vertices - (low + high) / 2) / size, mesh.faces, mesh.name)
    repaired, place = repair_mapped(centered)
    check_surface(repaired)
    corners = place[mesh.faces]
    whole_faces = np.flatnonzero(
        (corners >= 0).all(axis=1) & (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    )
    copy, kept = _largest_parts(resample(repaired, settings.floor, settings.budget))
    if len(copy.vertices) < len(repaired.vertices) or not kept.all():
        place = np.full(len(place), -1)  # simplified: no vertex is sure to be where it was
    unit = math.sqrt(copy.area)
    copy = Mesh(copy.vertices / unit, copy.faces, mesh.name)
    matrix = vertex_prolongation(copy, centered, centered.vertices / unit, place)
    ties, lengths = _ties(copy)
    spectrum = operator_spectrum(_tied(build_operator(copy), ties), settings.eigenpairs)
    faces, outward = _turned(copy)
    samples = farthest_points(copy.vertices, min(settings.samples, len(copy.vertices)))
    compared = samples[: settings.compared]
    normals = _vertex_normals(copy.vertices, faces)
    graph = distance_graph(copy, ties, lengths)
    distances = dijkstra(graph, directed=False, indices=compared).T
    return WorkingSurface(
        copy,
        Mesh(repaired.vertices / unit, corners[whole_faces], mesh.name),
        whole_faces,
        spectrum,
        matrix,
        unit * size,
        normals,
        faces,
        outward,
        samples,
        distances,
        graph,
        _tips(distances[compared], spectrum.mass[compared]),
        _descriptors(spectrum),
    )


def _parts(mesh: Mesh) -> tuple[int, IntArray]:
    start, end = mesh.faces[:, [0, 1]].ravel(), mesh.faces[:, [1, 2]].ravel()
    graph = sparse.coo_array((np.ones(len(start), np.int8), (start, end)), shape=2 * (len(mesh.vertices),))
    count, part = connected_components(graph, directed=False)
    return int(count), part


def _largest_parts(mesh: Mesh) -> tuple[Mesh, NDArray[np.bool_]]:
    """Keep the largest loose parts, and say which vertices they have."""
    count, part = _parts(mesh)
    if count <= _MOST_PARTS:
        return mesh, np.ones(len(mesh.vertices), bool)
    areas = np.bincount(part[mesh.faces[:, 0]], face_areas(mesh), count)
    kept = np.isin(part, np.argsort(-areas, kind="stable")[:_MOST_PARTS])
    faces = (np.cumsum(kept) - 1)[mesh.faces[kept[mesh.faces[:, 0]]]]
    return Mesh(mesh.vertices[kept], faces, mesh.name), kept


def _ties(mesh: Mesh) -> tuple[Indices, FloatArray]:
    """Pairs of vertices (t, 2) that join the loose parts into one, and their lengths (t,).

    Each part in turn, the nearest first, is tied to those before it where it comes closest: the eye to its
    socket, wherever the head is turned.
    """
    count, part = _parts(mesh)
    pairs, lengths = [np.empty((0, 2), np.int64)], [np.empty(0)]
    areas = np.bincount(part[mesh.faces[:, 0]], face_areas(mesh), count)
    newest = int(areas.argmax())
    outside = np.flatnonzero(part != newest)
    distance, nearest = np.full(len(outside), np.inf), np.zeros(len(outside), np.int64)
    while len(outside):
        members = np.flatnonzero(part == newest)
        to_newest, index = map(np.asarray, KDTree(mesh.vertices[members]).query(mesh.vertices[outside]))
        closer = to_newest < distance
        distance[closer], nearest[closer] = to_newest[closer], members[index[closer]]
        newest = int(part[outside[distance.argmin()]])
        own = np.flatnonzero(part[outside] == newest)
        own = own[np.argsort(distance[own], kind="stable")][:_MOST_TIES]
        own = own[distance[own] <= distance[own[0]] + _TIE_REACH]
        pairs.append(np.stack([outside[own], nearest[own]], axis=1))
        lengths.append(distance[own])
        rest = part[outside] != newest
        outside, distance, nearest = outside[rest], distance[rest], nearest[rest]
    return np.concatenate(pairs), np.concatenate(lengths)


def _tied(operator: Operator, ties: Indices) -> Operator:
    """Let heat cross the ties as it crosses an edge between two equilateral faces: cot 60°."""
    if not len(ties):
        return operator
    start, end = ties.T
    weight = np.full(len(ties), 1 / math.sqrt(3))
    links = sparse.coo_array(
        (
            np.concatenate([weight, weight, -weight, -weight]),
            (np.concatenate([start, end, start, end]), np.concatenate([start, end, end, start])),
        ),
        shape=operator.stiffness.shape,
    )
    return Operator(sparse.csc_array(operator.stiffness + links), operator.mass)


def distance_graph(mesh: Mesh, ties: Indices, tie_lengths: FloatArray) -> sparse.csr_array:
    """Edges, ties, and shortcuts across every edge between the two corners opposite to it.

    Along edges alone paths zigzag, and are some tenth too long.
    """
    n = len(mesh.vertices)
    sides = mesh.faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2).astype(np.int64)
    opposite = mesh.faces.ravel().astype(np.int64)
    keys = sides.min(axis=1) * n + sides.max(axis=1)
    order = np.argsort(keys, kind="stable")
    twin = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    one, other = order[twin], order[twin + 1]
    across = np.stack([opposite[one], opposite[other]], axis=1)
    a, b = mesh.vertices[sides[one, 0]], mesh.vertices[sides[one, 1]]
    across_lengths = _unfolded(a, b, mesh.vertices[across[:, 0]], mesh.vertices[across[:, 1]])
    edge_lengths = np.linalg.norm(mesh.vertices[sides[:, 0]] - mesh.vertices[sides[:, 1]], axis=1)
    pairs = np.concatenate([sides, across, ties])
    lengths = np.concatenate([edge_lengths, across_lengths, tie_lengths])
    # Several ways between two vertices: the shortest one counts, and a sparse array would add them up.
    pairs, lengths = pairs[np.isfinite(lengths)], lengths[np.isfinite(lengths)]
    keys = pairs.min(axis=1) * n + pairs.max(axis=1)
    order = np.lexsort([lengths, keys])
    keys, first = np.unique(keys[order], return_index=True)
    lengths = np.maximum(lengths[order[first]], 1e-12)  # no entry of the graph may be 0
    start, end = np.divmod(keys, n)
    return sparse.csr_array(sparse.coo_array((lengths, (start, end)), shape=(n, n)))


def _unfolded(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Distance of c and d when faces abc and bad are laid flat; infinite if the way leaves them."""
    side = b - a
    length = np.linalg.norm(side, axis=1)
    direction = side / np.maximum(length, np.finfo(float).tiny)[:, None]
    along = [((point - a) * direction).sum(axis=1) for point in (c, d)]
    height = [
        np.linalg.norm(point - a - x[:, None] * direction, axis=1)
        for point, x in zip((c, d), along, strict=True)
    ]
    total = np.maximum(height[0] + height[1], np.finfo(float).tiny)
    crossing = (along[0] * height[1] + along[1] * height[0]) / total
    inside = (crossing >= 0) & (crossing <= length)
    distance: FloatArray = np.where(inside, np.hypot(along[0] - along[1], height[0] + height[1]), np.inf)
    return distance


def _turned(mesh: Mesh) -> tuple[IntArray, bool]:
    """Faces turned the same way as their neighbours, outwards if the surface encloses something.

    Each part is turned by the volume that it encloses with its centre; an open one that encloses next to
    nothing stays as most of its faces are.
    """
    m, n = len(mesh.faces), len(mesh.vertices)
    sides = mesh.faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2).astype(np.int64)
    keys = sides.min(axis=1) * n + sides.max(axis=1)
    _, place, counts = np.unique(keys, return_inverse=True, return_counts=True)
    order = np.argsort(keys, kind="stable")
    order = order[counts[place[order]] == 2]  # where more than two faces meet, none is the neighbour
    one, other = order[::2], order[1::2]
    same_way = sides[one, 0] == sides[other, 0]  # neighbours turned alike run along their edge oppositely
    pairs = np.concatenate([np.stack([one, other]) // 3, np.stack([other, one]) // 3], axis=1)
    value = np.tile(np.where(same_way, 2, 1), 2).astype(np.int8)
    graph = sparse.csr_array(sparse.coo_array((value, (pairs[0], pairs[1])), shape=(m, m)))
    graph.data = np.minimum(graph.data, 2)
    part_count, part = connected_components(graph, directed=False)
    flipped = np.zeros(m, bool)
    for first in np.unique(part, return_index=True)[1]:
        visited, parent = breadth_first_order(graph, int(first), directed=False)
        own = visited[1:]
        against = np.asarray(graph[own, parent[own]]).ravel() == 2 if len(own) else np.empty(0, bool)
        for face, before, turn in zip(own.tolist(), parent[own].tolist(), against.tolist(), strict=True):
            flipped[face] = flipped[before] ^ turn
    areas = face_areas(mesh)
    part_areas = np.bincount(part, areas, part_count)
    corners = mesh.vertices[mesh.faces]
    centers = np.stack(
        [np.bincount(part, areas * axis, part_count) for axis in corners.mean(axis=1).T], axis=1
    )
    corners = corners - (centers / np.maximum(part_areas, np.finfo(float).tiny)[:, None])[part][:, None]
    volumes = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volumes[flipped] *= -1
    enclosed = np.bincount(part, volumes, part_count) / np.maximum(part_areas, np.finfo(float).tiny) ** 1.5
    tells = np.abs(enclosed) > _LEAST_VOLUME
    minority = np.bincount(part, areas * np.where(flipped, 1, -1), part_count) > 0
    flipped ^= np.where(tells, enclosed < 0, minority)[part]
    outward = bool(part_areas[tells].sum() > 0.5 * part_areas.sum())
    return np.where(flipped[:, None], mesh.faces[:, ::-1], mesh.faces).astype(np.int32), outward


def _vertex_normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    weighted = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    summed = np.stack([np.bincount(faces.ravel(), axis, len(vertices)) for axis in weighted.T], axis=1)
    normals: FloatArray = summed / np.maximum(
        np.linalg.norm(summed, axis=1, keepdims=True), np.finfo(float).tiny
    )
    return normals


def _tips(distances: FloatArray, mass: FloatArray) -> Indices:
    """Find the samples that are farther from all the surface than those around them (Hilaga et al. 2001)."""
    average = distances @ mass / mass.sum()
    around = np.where(distances <= _TIP_RADIUS, average, 0).max(axis=1)
    tips = np.flatnonzero((average >= around) & (average > np.median(average)))
    return tips[np.argsort(-average[tips], kind="stable")][:_MOST_TIPS]


def _descriptors(spectrum: Spectrum) -> FloatArray:
    values = [
        log_heat_kernel_signature(spectrum, _HEAT_TIMES),
        wave_kernel_signature(spectrum, _WAVE_ENERGIES, sigma=_WAVE_SIGMA),
    ]
    blocks = []
    for block in values:
        mean = spectrum.mass @ block / spectrum.area
        spread = np.sqrt(spectrum.mass @ (block - mean) ** 2 / spectrum.area)
        blocks.append((block - mean) / np.maximum(spread, 1e-9) / math.sqrt(2 * block.shape[1]))
    return np.concatenate(blocks, axis=1)
