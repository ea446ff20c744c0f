# SPDX-License-Identifier: GPL-3.0-or-later
"""Test whether two meshes are the same geometry, moved, rotated or scaled, in any order of vertices.

Mirror images are not congruent here: only proper rotations are searched. (A shape that is its own mirror
image is congruent to its reflection all the same.)

Where the order of the vertices differs, two vertices that few others resemble (by their distance from the
centroid and their number of edges) are put onto each pair of the other mesh that could be theirs. Two vectors
fix a rotation; the nearest vertices then tell the order, and the polygons have to agree.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shapegoogle_core.mesh.mesh import FloatArray

from ..time_slices import aside

__all__ = ["LARGE", "TOLERANCE", "Congruence", "PolygonMesh", "congruence", "congruence_steps"]

Indices = NDArray[np.int64]

TOLERANCE = 1e-4
"""How far a vertex may lie from its partner, relative to the size of the mesh."""

# While the order is unknown, the rotation is that of two vertices only and less exact than the best fit.
LOOSE = 10
# Vertices by which a rotation is judged before all are compared.
PROBES = 32
# Rotations that are tried. Where none fits because too many vertices are alike, meshes count as different.
MOST_ROTATIONS = 2_000
MOST_FULL_TRIES = 8
# Vertices from which on meshes are compared in another thread.
LARGE = 50_000


@dataclass(frozen=True, eq=False)
class PolygonMesh:
    """A mesh with polygons as they are, not cut into triangles.

    Attributes
    ----------
    vertices : (n, 3) array of float64
    corners : (c,) array of int64
        Vertex of each corner, polygon after polygon.
    sizes : (m,) array of int64
        How many corners each polygon has.
    edges : (e, 2) array of int64
        All edges, also those of no polygon.
    """

    vertices: FloatArray
    corners: Indices
    sizes: Indices
    edges: Indices

    @cached_property
    def centroid(self) -> FloatArray:
        """(3,) mean of the vertices."""
        return np.asarray(self.vertices.mean(axis=0))

    @cached_property
    def radii(self) -> FloatArray:
        """(n,) distance of each vertex from the centroid."""
        return np.asarray(np.linalg.norm(self.vertices - self.centroid, axis=1))

    @property
    def size(self) -> float:
        """Twice the largest distance of a vertex from the centroid; 0 without extent."""
        return 2 * float(self.radii.max(initial=0))

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Numbers that congruent meshes share: vertices, edges, and polygons of 3, 4, … corners."""
        return (len(self.vertices), len(self.edges), *np.bincount(self.sizes).tolist())

    @cached_property
    def profile(self) -> FloatArray:
        """(n,) sorted distances from the centroid, relative to the size."""
        return np.sort(self.radii) / self.size

    @cached_property
    def compactness(self) -> float:
        """Mean of `profile`. Of congruent meshes it differs by no more than twice the tolerance."""
        return float(self.profile.mean())

    @cached_property
    def degrees(self) -> Indices:
        """(n,) number of edges at each vertex."""
        return np.bincount(self.edges.ravel(), minlength=len(self.vertices)).astype(np.int64)


@dataclass(frozen=True, eq=False)
class Congruence:
    """How the first mesh comes onto the second.

    Attributes
    ----------
    matrix : (4, 4) array
        Rotation, uniform scale and translation, for column vectors.
    scale : float
        Size of the second relative to the first.
    error : float
        Largest distance of a moved vertex from its partner, relative to the size of the second.
    vertex_order, corner_order, polygon_order, edge_order : (n,), (c,), (m,), (e,) arrays of int64
        Which vertex, corner, polygon and edge of the second each one of the first comes to lie on.
    """

    matrix: FloatArray
    scale: float
    error: float
    vertex_order: Indices
    corner_order: Indices
    polygon_order: Indices
    edge_order: Indices

    @property
    def same_order(self) -> bool:
        """Whether both meshes count their vertices and corners alike."""
        return all(
            np.array_equal(order, np.arange(len(order)))
            for order in (self.vertex_order, self.corner_order, self.polygon_order)
        )


def congruence(first: PolygonMesh, second: PolygonMesh, tolerance: float = TOLERANCE) -> Congruence | None:
    """Find the motion and scale that carry one mesh onto another.

    Parameters
    ----------
    first, second : PolygonMesh
    tolerance : float, optional
        How far a vertex may end from its partner, relative to the size of the second mesh.

    Returns
    -------
    congruence : Congruence or None
        None when there is none, when a mesh has no extent, or when its symmetry or coincident faces leave the
        order of its vertices open (see `MOST_ROTATIONS`).
    """
    if first.counts != second.counts or not len(first.vertices):
        return None
    if not (first.size > 0 and second.size > 0):
        return None
    if np.abs(first.profile - second.profile).max() > 2 * tolerance:
        return None
    if np.array_equal(first.corners, second.corners) and np.array_equal(first.sizes, second.sizes):
        orders = tuple(np.arange(len(each)) for each in (first.vertices, first.corners, first.sizes))
        found = _fit(first, second, orders, tolerance)
        if found is not None:
            return found
    target = _Target(second)
    for rotation in _rotations(first, second, target, tolerance):
        matched = target.match(first, rotation, LOOSE * tolerance)
        if matched is not None:
            found = _fit(first, second, matched, tolerance)
            if found is not None:
                return found
    return None


def congruence_steps(first: PolygonMesh, second: PolygonMesh) -> Generator[bool, None, Congruence | None]:
    """Compare two meshes as `congruence` does, large ones while the window answers.

    Parameters
    ----------
    first, second : PolygonMesh

    Yields
    ------
    alone : bool
        See `..time_slices.next_slice`.

    Returns
    -------
    congruence : Congruence or None
    """
    if len(first.vertices) < LARGE or first.counts != second.counts:
        return congruence(first, second)
    return (yield from aside(lambda: congruence(first, second)))


def _fit(
    first: PolygonMesh, second: PolygonMesh, orders: tuple[Indices, ...], tolerance: float
) -> Congruence | None:
    """Best motion and scale once the order is known (Kabsch, Umeyama); None if a vertex stays off."""
    vertex_order, corner_order, polygon_order = orders
    edge_order = _edge_order(first, second, vertex_order)
    if edge_order is None:
        return None
    start, end = first.vertices - first.centroid, second.vertices[vertex_order] - second.centroid
    rotation = _kabsch(start, end)
    scale = float(np.sqrt((end**2).sum() / (start**2).sum()))
    error = float(np.linalg.norm(scale * start @ rotation.T - end, axis=1).max() / second.size)
    if error > tolerance:
        return None
    matrix = np.eye(4)
    matrix[:3, :3] = scale * rotation
    matrix[:3, 3] = second.centroid - matrix[:3, :3] @ first.centroid
    return Congruence(matrix, scale, error, vertex_order, corner_order, polygon_order, edge_order)


def _kabsch(start: FloatArray, end: FloatArray) -> FloatArray:
    """Proper rotation that carries centred points onto others, best in the sense of least squares."""
    left, _, right = np.linalg.svd(end.T @ start)
    left[:, 2] *= np.sign(np.linalg.det(left @ right))
    return np.asarray(left @ right)


def _edge_order(first: PolygonMesh, second: PolygonMesh, vertex_order: Indices) -> Indices | None:
    """Which edge of the second each one of the first becomes; None when they are not the same edges."""
    ends = [edges.T for edges in (vertex_order[first.edges], second.edges)]
    keys = [np.minimum(*pair) * len(vertex_order) + np.maximum(*pair) for pair in ends]
    if np.array_equal(*keys):  # as of most copies: to sort millions of them takes long
        return np.arange(len(keys[0]))
    sorting = [np.argsort(key, kind="stable") for key in keys]
    if not np.array_equal(keys[0][sorting[0]], keys[1][sorting[1]]):
        return None
    order = np.empty(len(keys[0]), np.int64)
    order[sorting[0]] = sorting[1]
    return order


class _Target:
    """The second mesh, centred and of size 1, its coincident vertices taken together as places."""

    def __init__(self, mesh: PolygonMesh) -> None:
        self.mesh = mesh
        self.vertices = (mesh.vertices - mesh.centroid) / mesh.size
        places, self.place_of = _unique_rows(self.vertices)
        self.count = len(places)
        self.tree = cKDTree(places)

    def match(
        self, first: PolygonMesh, rotation: FloatArray, reach: float
    ) -> tuple[Indices, Indices, Indices] | None:
        """Order of vertices, corners and polygons under a rotation; None when they do not fall together."""
        turned = (first.vertices - first.centroid) @ rotation.T / first.size
        distances, nearest = self.tree.query(turned, distance_upper_bound=reach)
        places = np.asarray(nearest, np.int64)
        if not np.isfinite(distances).all():
            return None
        per_place = np.bincount(self.place_of, minlength=self.count)
        if not np.array_equal(np.bincount(places, minlength=self.count), per_place):
            return None
        polygons = _polygon_order(first, places, self.mesh, self.place_of)
        if polygons is None:
            return None
        polygon_order, corner_order = polygons
        vertex_order = np.full(len(places), -1, np.int64)
        vertex_order[first.corners] = self.mesh.corners[corner_order]
        if not np.array_equal(vertex_order[first.corners], self.mesh.corners[corner_order]):
            return None  # coincident faces: which is which is open
        # Vertices of no polygon take the remaining partner at their place.
        free = np.flatnonzero(vertex_order < 0)
        left = np.setdiff1d(np.arange(len(places)), vertex_order)
        if len(free) != len(left):
            return None
        free = free[np.argsort(places[free], kind="stable")]
        left = left[np.argsort(self.place_of[left], kind="stable")]
        if not np.array_equal(places[free], self.place_of[left]):
            return None
        vertex_order[free] = left
        return vertex_order, corner_order, polygon_order


def _unique_rows(rows: FloatArray) -> tuple[FloatArray, Indices]:
    """Sorted rows without repetitions, and which of them each row is.

    As numpy's `unique` does, which keeps all other threads waiting meanwhile.
    """
    order = np.lexsort(rows.T[::-1])
    in_order = rows[order]
    is_new = np.concatenate([[True], (in_order[1:] != in_order[:-1]).any(axis=1)])
    which = np.empty(len(rows), np.int64)
    which[order] = np.cumsum(is_new) - 1
    return in_order[is_new], which


def _polygon_order(
    first: PolygonMesh, first_labels: Indices, second: PolygonMesh, second_labels: Indices
) -> tuple[Indices, Indices] | None:
    """Match polygons by the labels of their corners, from whichever corner they start."""
    polygon_order = np.empty(len(first.sizes), np.int64)
    corner_order = np.empty(len(first.corners), np.int64)
    for size in np.unique(first.sizes):
        rings = []
        for mesh, labels in ((first, first_labels), (second, second_labels)):
            polygons = np.flatnonzero(mesh.sizes == size)
            starts = (np.cumsum(mesh.sizes) - mesh.sizes)[polygons]
            corners = starts[:, None] + np.arange(size)
            begin = labels[mesh.corners[corners]].argmin(axis=1)
            turned = (begin[:, None] + np.arange(size)) % size
            corners = np.take_along_axis(corners, turned, axis=1)
            ring = labels[mesh.corners[corners]]
            sorting = np.lexsort(ring.T[::-1])
            rings.append((ring[sorting], polygons[sorting], corners[sorting]))
        (ring, polygons, corners), (other_ring, other_polygons, other_corners) = rings
        if not np.array_equal(ring, other_ring):
            return None
        polygon_order[polygons] = other_polygons
        corner_order[corners] = other_corners
    return polygon_order, corner_order


def _rotations(
    first: PolygonMesh, second: PolygonMesh, target: _Target, tolerance: float
) -> list[FloatArray]:
    """Rotations worth a full comparison, the likeliest first."""
    points = (first.vertices - first.centroid) / first.size
    loose = LOOSE * tolerance
    pairs = _anchors(points, first, second, tolerance)
    # Where symmetry leaves a choice, a mesh that is not turned should not be. Or only the polygons may be out
    # of order, and the vertices not.
    candidates = [np.eye(3)[None], _kabsch(points, target.vertices)[None]]
    if pairs is not None:
        (one, two), partners = pairs
        candidates.append(
            _frames(target.vertices[partners[:, 0]], target.vertices[partners[:, 1]])
            @ _frames(points[one][None], points[two][None]).transpose(0, 2, 1)
        )
    rotations = np.concatenate(candidates)
    probes = points[np.linspace(0, len(points) - 1, min(PROBES, len(points))).astype(int)]
    turned = np.einsum("rij,pj->rpi", rotations, probes)
    distances = np.asarray(target.tree.query(turned.reshape(-1, 3))[0])
    distances = distances.reshape(len(rotations), -1).max(axis=1)
    # Among rotations that are equally good the first ones win.
    order = np.argsort(np.round(distances / tolerance), kind="stable")[:MOST_FULL_TRIES]
    return [rotations[index] for index in order if distances[index] <= loose]


def _anchors(
    points: FloatArray, first: PolygonMesh, second: PolygonMesh, tolerance: float
) -> tuple[tuple[int, int], Indices] | None:
    """Choose two vertices of the first mesh, and list the pairs of the second that could be theirs."""
    ends = (second.vertices - second.centroid) / second.size
    radii, other_radii = first.radii / first.size, second.radii / second.size
    alike = np.zeros(len(points), np.int64)
    for degree in np.unique(first.degrees):
        members = np.flatnonzero(first.degrees == degree)
        values = np.sort(other_radii[second.degrees == degree])
        low, high = (np.searchsorted(values, radii[members] + d) for d in (-2 * tolerance, 2 * tolerance))
        alike[members] = high - low

    def rarest(levers: FloatArray) -> int:
        # A short lever would turn a small error of a vertex into a large one of the angle.
        usable = np.flatnonzero(levers >= 0.5 * levers.max())
        return int(usable[np.lexsort((-levers[usable], alike[usable]))[0]])

    one = rarest(radii)
    across = np.linalg.norm(np.cross(points, points[one] / radii[one]), axis=1)
    if not across.max() > LOOSE * tolerance:
        return None  # all on a line
    two = rarest(across)
    partners = [
        np.flatnonzero(
            (np.abs(other_radii - radii[anchor]) <= 2 * tolerance) & (second.degrees == first.degrees[anchor])
        )
        for anchor in (one, two)
    ]
    apart = np.linalg.norm(points[one] - points[two])
    found: list[Indices] = [np.empty((0, 2), np.int64)]
    total = 0
    for partner in partners[0]:
        gaps = np.linalg.norm(ends[partners[1]] - ends[partner], axis=1)
        fitting = partners[1][np.abs(gaps - apart) <= 4 * tolerance]
        found.append(np.stack([np.full(len(fitting), partner), fitting], axis=1))
        total += len(fitting)
        if total >= MOST_ROTATIONS:
            break
    return (one, two), np.concatenate(found)[:MOST_ROTATIONS]


def _frames(first: FloatArray, second: FloatArray) -> FloatArray:
    """(r, 3, 3) right-handed orthonormal frames, as columns, of pairs of vectors."""
    x = first / np.linalg.norm(first, axis=1, keepdims=True)
    z = np.cross(first, second)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)
