# SPDX-License-Identifier: MIT
"""Matching of two meshes: the point of one for every point of the other, with its confidence."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from shapegoogle_core.correspondence.functional_maps import FunctionalMaps, nearest_in_faces
from shapegoogle_core.correspondence.map_selection import Candidate, best_maps, stretches
from shapegoogle_core.correspondence.working_surface import SurfaceSettings, WorkingSurface, working_surface
from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.mesh.mesh_like import MeshLike, as_mesh
from shapegoogle_core.mesh.prolongation import nearest_faces

__all__ = [
    "ShapeMap",
    "SurfacePoints",
    "VertexMatch",
    "find_map",
    "match_vertices",
    "match_with_points",
    "vertex_match",
]

Indices = NDArray[np.int64]

# A shape is symmetric if another map has at most this much more distortion than the best one, or than the
# right map of a re-meshed shape.
_AS_GOOD, _REMESHED = 0.012, 0.01
# Logistic regression of the confidence on two errors in units of √area (docs/concepts/correspondence.md).
_CONSTANT, _RETURN_WEIGHT, _STRETCH_WEIGHT = 4.5, 52.0, 56.0


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points on the faces of a mesh.

    Attributes
    ----------
    face : (p,) array of int
        Face of each point; −1 where there is no point.
    weights : (p, 3) array
        Barycentric coordinates in the face. They are ≥ 0 and sum to 1; all are 0 where there is no point.
    """

    face: Indices
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class VertexMatch:
    """Correspondence of each vertex of a mesh a with a point of a mesh b.

    Attributes
    ----------
    face, weights : (n,), (n, 3) arrays
        The point of b: a face, and the barycentric coordinates in it. −1 and 0 for vertices of a that no face
        uses.
    vertex : (n,) array of int
        Nearest corner of that face; −1 as above.
    confidence : (n,) array
        From 0 to 1: about the share of vertices with this confidence whose match has an error below 0.05
        √area. It is estimated from the distance between a vertex and its image under the maps to b and back,
        and from the change of distances to points all over the shape. It does not detect that a symmetric
        shape was matched with its mirror image: see `symmetric`. 0 for vertices that no face uses.
    orthogonality : float
        ‖CᵀC − I‖ / √k of the functional map C of size k, in the Frobenius norm: 0 if areas are preserved.
    commutativity : float
        ‖CΛ_b − Λ_a C‖ / ‖Λ_a C‖, with the eigenvalues Λ of the shapes scaled to unit area: 0 for an isometry.
    area_distortion : float
        Share of the area that faces gain or lose by the map, with both surfaces scaled to unit area.
    distortion : float
        Mean change of distances, plus the mean distance between points and their images under the maps to b
        and back, in units of √area. Typically 0.01 to 0.06 for a shape in another pose. Above 0.1 the two are
        not the same shape, or the match failed.
    orientation : float
        From −1, if b is a mirror image of a or was matched with left and right exchanged, to 1. 0 if one of
        the two does not enclose a volume, so that inside and outside are not known.
    runner_up : float
        Cost of the next best map, relative to that of the chosen one. The cost grows with the distortion and
        the difference of descriptors, and doubles for a map that turns the surface inside out. A value near
        1 is a close choice; infinity means that there is no other map.
    symmetric : bool
        Whether another map preserves distances as well (its distortion is at most 0.012 higher): the shape
        resembles its mirror image, or itself in another way. Where inside and outside are known, the mirror
        image is nevertheless distinguished, and `runner_up` is the margin.

    Examples
    --------
    The point of b that corresponds to each vertex of a, here of a single one:

    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> b = sg.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> match = sg.VertexMatch(
    ...     face=np.array([0]),
    ...     weights=np.array([[0.5, 0.25, 0.25]]),
    ...     vertex=np.array([0]),
    ...     confidence=np.array([0.9]),
    ...     orthogonality=0.1,
    ...     commutativity=0.1,
    ...     area_distortion=0.02,
    ...     distortion=0.03,
    ...     orientation=1.0,
    ...     runner_up=2.0,
    ...     symmetric=False,
    ... )
    >>> (match.weights[:, :, None] * b.vertices[b.faces[match.face]]).sum(axis=1).tolist()
    [[0.25, 0.25, 0.0]]
    """

    face: Indices
    weights: FloatArray
    vertex: Indices
    confidence: FloatArray
    orthogonality: float
    commutativity: float
    area_distortion: float
    distortion: float
    orientation: float
    runner_up: float
    symmetric: bool


@dataclass(frozen=True, eq=False)
class ShapeMap:
    """Map from a mesh a to a mesh b.

    Attributes
    ----------
    a, b : WorkingSurface
    candidate : Candidate
        The chosen map, in the bases of both.
    others : tuple of Candidate
        Different maps, the best first.
    """

    a: WorkingSurface
    b: WorkingSurface
    candidate: Candidate
    others: tuple[Candidate, ...]

    def vertices(self) -> SurfacePoints:
        """Map the vertices of a.

        Returns
        -------
        points : SurfacePoints
            Points on b.
        """
        placed = np.diff(self.a.prolongation.indptr) > 0
        face = np.full(len(placed), -1)
        weights = np.zeros((len(placed), 3))
        face[placed], weights[placed] = self._on_b(self.a.prolongation[placed] @ self.a.spectrum.eigenvectors)
        return SurfacePoints(face, weights)

    def points(self, corners: Indices, weights: FloatArray) -> SurfacePoints:
        """Map points in the faces of a.

        Parameters
        ----------
        corners : (p, 3) array of int
            Vertices of a, three for each face.
        weights : (p, 3) array
            Barycentric coordinates of the points in these faces.

        Returns
        -------
        points : SurfacePoints
            Points on b.
        """
        functions = self.a.prolongation @ self.a.spectrum.eigenvectors
        return SurfacePoints(*self._on_b(np.einsum("pi,pik->pk", weights, functions[corners])))

    def _on_b(self, functions: FloatArray) -> tuple[Indices, FloatArray]:
        """Return faces of b as given and coordinates in them, for the eigenfunctions at points of a."""
        b, maps = self.b, self.candidate.maps
        face, weights = nearest_in_faces(
            maps.embed_a(functions), maps.embed_b(b.spectrum.eigenvectors), b.mesh.faces
        )
        places = np.einsum("pi,pid->pd", weights, b.mesh.vertices[b.mesh.faces[face]])
        face, weights = nearest_faces(b.whole, places)
        return b.whole_faces[face], weights


def find_map(a: MeshLike, b: MeshLike, settings: SurfaceSettings | None = None) -> ShapeMap:
    """Find the map between a shape and the same shape in another pose, with another mesh, or both.

    Functional maps (Ovsjanikov et al. 2012) are refined by spectral upsampling (ZoomOut, Melzi et al. 2019)
    in both directions, on clean copies of a few thousand vertices. The refinement starts from many initial
    maps. The best result preserves distances and descriptors most, and of mirror images is the one that does
    not turn the surface inside out.

    Parameters
    ----------
    a, b : MeshLike
        Whole shapes of any size, position and resolution. They may be open or have several parts.
    settings : SurfaceSettings, optional
        Resolution of the copies.

    Returns
    -------
    shape_map : ShapeMap

    Raises
    ------
    MeshError
        If a mesh has no surface, or its eigenproblem cannot be solved.
    """
    settings = settings or SurfaceSettings()
    a, b = as_mesh(a, "a"), as_mesh(b, "b")
    # On matrices of this size more BLAS threads only slow each other down.
    with threadpool_limits(1, user_api="blas"):
        surface_a, surface_b = working_surface(a, settings), working_surface(b, settings)
        chosen, *others = best_maps(surface_a, surface_b)
    return ShapeMap(surface_a, surface_b, chosen, tuple(others))


def match_vertices(a: MeshLike, b: MeshLike, settings: SurfaceSettings | None = None) -> VertexMatch:
    """Find the corresponding point of a mesh b for each vertex of a mesh a.

    Parameters
    ----------
    a, b : MeshLike
        Nearly the same shape: the poses, sizes and meshes may differ. See `find_map` for the method.
    settings : SurfaceSettings, optional
        Resolution of the copies on which the shapes are matched.

    Returns
    -------
    match : VertexMatch

    Raises
    ------
    MeshError
        If a mesh has no surface, or its eigenproblem cannot be solved.

    Examples
    --------
    >>> import numpy as np
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> bar = trimesh.creation.capsule(3.0, 0.4)
    >>> bent = bar.copy()
    >>> bent.vertices[:, 0] += 0.1 * bar.vertices[:, 2] ** 2
    >>> match = sg.match_vertices(bar, bent)
    >>> match.vertex.shape, match.distortion < 0.06
    ((2050,), True)
    """
    b = as_mesh(b, "b")
    return vertex_match(find_map(a, b, settings), b)


def match_with_points(
    a: Mesh, b: Mesh, faces: Indices, settings: SurfaceSettings | None = None
) -> tuple[VertexMatch, SurfacePoints]:
    """Match vertices and the centres of some faces.

    Parameters
    ----------
    a, b : Mesh
        As for `match_vertices`.
    faces : (p,) array of int
        Faces of a.
    settings : SurfaceSettings, optional
        As for `match_vertices`.

    Returns
    -------
    match : VertexMatch
    centers : SurfacePoints
        Points of b that correspond to the centres of these faces.

    Raises
    ------
    MeshError
        If a mesh has no surface, or its eigenproblem cannot be solved.
    """
    shape_map = find_map(a, b, settings)
    centers = shape_map.points(a.faces[faces].astype(np.int64), np.full((len(faces), 3), 1 / 3))
    return vertex_match(shape_map, b), centers


def vertex_match(shape_map: ShapeMap, b: Mesh) -> VertexMatch:
    """Apply a map to the vertices of its first mesh, and measure its quality.

    Parameters
    ----------
    shape_map : ShapeMap
    b : Mesh
        Second mesh of the map.

    Returns
    -------
    match : VertexMatch
    """
    with threadpool_limits(1, user_api="blas"):
        points = shape_map.vertices()
        confidence, area_distortion = _confidence(shape_map)
    corner = b.faces[points.face, points.weights.argmax(axis=1)]
    chosen, runner_up = shape_map.candidate, np.inf
    as_good = max(chosen.distortion, _REMESHED) + _AS_GOOD
    if shape_map.others:
        runner_up = shape_map.others[0].cost / chosen.cost
    eigenvalues = [surface.spectrum.eigenvalues for surface in (shape_map.a, shape_map.b)]
    return VertexMatch(
        face=points.face,
        weights=points.weights,
        vertex=np.where(points.face < 0, -1, corner).astype(np.int64),
        confidence=shape_map.a.prolongation @ confidence,
        orthogonality=orthogonality(chosen.maps),
        commutativity=commutativity(chosen.maps, *eigenvalues),
        area_distortion=area_distortion,
        distortion=chosen.distortion,
        orientation=chosen.orientation,
        runner_up=float(runner_up),
        symmetric=any(other.distortion <= as_good for other in shape_map.others),
    )


def orthogonality(maps: FunctionalMaps) -> float:
    """Compute ‖CᵀC − I‖ / √k; see `VertexMatch`.

    Parameters
    ----------
    maps : FunctionalMaps

    Returns
    -------
    orthogonality : float
    """
    k = len(maps.to_a)
    return float(np.linalg.norm(maps.to_a.T @ maps.to_a - np.eye(k))) / math.sqrt(k)


def commutativity(maps: FunctionalMaps, eigenvalues_a: FloatArray, eigenvalues_b: FloatArray) -> float:
    """Compute ‖CΛ_b − Λ_a C‖ / ‖Λ_a C‖; see `VertexMatch`.

    Parameters
    ----------
    maps : FunctionalMaps
    eigenvalues_a, eigenvalues_b : (≥ k,) arrays

    Returns
    -------
    commutativity : float
    """
    c, k = maps.to_a, len(maps.to_a)
    ours = eigenvalues_a[:k, None] * c
    return float(np.linalg.norm(c * eigenvalues_b[:k] - ours)) / max(float(np.linalg.norm(ours)), 1e-12)


def vertex_errors(shape_map: ShapeMap) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Estimate errors of the match of each vertex of the copy of a.

    Parameters
    ----------
    shape_map : ShapeMap

    Returns
    -------
    returned : (n,) array
        Distance of the vertex from its image under the maps to b and back, in units of √area.
    stretched : (n,) array
        Mean change of the distances to the compared samples, in the same unit.
    images : (n, 3) array
        Images of the vertices on the copy of b.
    """
    a, b, maps = shape_map.a, shape_map.b, shape_map.candidate.maps
    places_a = maps.embed_a(a.spectrum.eigenvectors)
    places_b = maps.embed_b(b.spectrum.eigenvectors)
    face, weights = nearest_in_faces(places_a, places_b, b.mesh.faces)
    there = np.einsum("pi,pik->pk", weights, places_b[b.mesh.faces[face]])
    face_back, weights_back = nearest_in_faces(there, places_a, a.mesh.faces)
    back = np.einsum("pi,pid->pd", weights_back, a.mesh.vertices[a.mesh.faces[face_back]])
    returned = np.linalg.norm(back - a.mesh.vertices, axis=1)
    stretched = stretches(a, b, b.mesh.faces[face, weights.argmax(axis=1)].astype(np.int64))
    images = np.einsum("pi,pid->pd", weights, b.mesh.vertices[b.mesh.faces[face]])
    return returned, stretched, images


def _confidence(shape_map: ShapeMap) -> tuple[FloatArray, float]:
    """Return the (n,) confidence at the vertices of the copy of a, and the distortion of areas."""
    returned, stretched, images = vertex_errors(shape_map)
    odds = _CONSTANT - _RETURN_WEIGHT * returned - _STRETCH_WEIGHT * stretched
    before = face_areas(shape_map.a.mesh)
    after = face_areas(Mesh(images, shape_map.a.mesh.faces))
    return 1 / (1 + np.exp(-odds)), float(np.abs(after - before).sum() / before.sum())
