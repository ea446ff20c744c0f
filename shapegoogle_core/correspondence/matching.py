# SPDX-License-Identifier: MIT
"""Matching two meshes: for every point of one the point of the other, and how far to trust it."""

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

# Another map that distorts at most so much more is as good: the shape is symmetric. A shape meshed anew is
# distorted a little even by the right map, the very same mesh is not.
_AS_GOOD, _REMESHED = 0.012, 0.01
# Logarithmic odds of the confidence: what speaks against a match, in units of √area. Logistic regression on
# procedural creatures (seeds 101 and 104): 59 with themselves in another pose, 9 of which a fifth is missing,
# and 16 with a creature of another kind, where every match is wrong.
_CONSTANT, _RETURN_WEIGHT, _STRETCH_WEIGHT = 4.5, 52.0, 56.0


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """Points on a mesh.

    Attributes
    ----------
    face : (p,) array of int
        −1 where there is no point.
    weights : (p, 3) array
        Barycentric coordinates in the face: ≥ 0, sum to 1; all 0 where there is no point.
    """

    face: Indices
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class VertexMatch:
    """For every vertex of a mesh a the point of a mesh b that it corresponds to.

    Attributes
    ----------
    face, weights : (n,), (n, 3) arrays
        The point: a face of b and the barycentric coordinates in it. −1 and 0 for vertices of a that no
        face uses.
    vertex : (n,) array of int
        The corner of that face that is nearest; −1 as above.
    confidence : (n,) array
        From 0 to 1: about the share of vertices with such a confidence whose match is less than 0.05 √area
        off, judged by how far off one comes back (the map from b to a is found too) and by how well
        distances to points all over the shape are kept. It cannot know whether a symmetric shape was
        matched with its mirror image: see `symmetric`. 0 for vertices that no face uses.
    orthogonality : float
        ‖CᵀC − I‖ / √k of the functional map C of size k, Frobenius norm: 0 if areas are kept.
    commutativity : float
        ‖CΛ_b − Λ_a C‖ / ‖Λ_a C‖, with eigenvalues Λ of shapes scaled to unit area: 0 for an isometry.
    area_distortion : float
        Share of the area that faces gain or lose when they are mapped, both surfaces scaled to unit area.
    distortion : float
        Mean change of distances, and of a point that goes there and back, in units of √area. About 0.01 to
        0.06 for a shape in another pose; above 0.1 the two are not the same shape, or were not matched.
    orientation : float
        From −1, b is a mirror image of a or was matched with left and right exchanged, to 1; 0 if one of the
        two does not enclose a volume, so that inside and outside are not known.
    runner_up : float
        Cost of the next best map, which maps to other places, as a multiple of the chosen one's. The cost
        grows with the distortion and with the difference of descriptors, and is twice that for a map that
        turns the surface inside out. Near 1 the choice was a close one; infinity if there is no other map.
    symmetric : bool
        Whether another map keeps distances as well (a distortion up to 0.012 higher): the shape is like its
        mirror image, or otherwise like itself. Where inside and outside are known the mirror image
        is told apart all the same, and `runner_up` says by how much.
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
    """A map from a mesh a to a mesh b.

    Attributes
    ----------
    a, b : WorkingSurface
    candidate : Candidate
        The chosen map, in the bases of both.
    others : tuple of Candidate
        Maps to other places, the best first.
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
            On b.
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
            Vertices of a, each in a face.
        weights : (p, 3) array
            Barycentric coordinates between them.

        Returns
        -------
        points : SurfacePoints
            On b.
        """
        functions = self.a.prolongation @ self.a.spectrum.eigenvectors
        return SurfacePoints(*self._on_b(np.einsum("pi,pik->pk", weights, functions[corners])))

    def _on_b(self, functions: FloatArray) -> tuple[Indices, FloatArray]:
        """Faces of b as given and coordinates there, for points of a by their eigenfunctions."""
        b, maps = self.b, self.candidate.maps
        face, weights = nearest_in_faces(
            maps.embed_a(functions), maps.embed_b(b.spectrum.eigenvectors), b.mesh.faces
        )
        places = np.einsum("pi,pid->pd", weights, b.mesh.vertices[b.mesh.faces[face]])
        face, weights = nearest_faces(b.whole, places)
        return b.whole_faces[face], weights


def find_map(a: Mesh, b: Mesh, settings: SurfaceSettings | None = None) -> ShapeMap:
    """Find the map between two shapes of which one is the other in another pose, of another mesh, or both.

    Functional maps (Ovsjanikov et al. 2012) refined by spectral upsampling (ZoomOut, Melzi et al. 2019), in
    both directions, on clean copies of a few thousand vertices. The refinement starts from many first maps;
    the one that keeps distances and descriptors best is taken, and of mirror images the one that does not
    turn the surface inside out.

    Parameters
    ----------
    a, b : Mesh
        Of any size, position and resolution; whole shapes, also open or in several parts.
    settings : SurfaceSettings, optional

    Returns
    -------
    shape_map : ShapeMap

    Raises
    ------
    MeshError
        If a mesh has no surface, or its eigenproblem cannot be solved.
    """
    settings = settings or SurfaceSettings()
    # On matrices of this size more threads of BLAS only get in each other's way.
    with threadpool_limits(1, user_api="blas"):
        surface_a, surface_b = working_surface(a, settings), working_surface(b, settings)
        chosen, *others = best_maps(surface_a, surface_b)
    return ShapeMap(surface_a, surface_b, chosen, tuple(others))


def match_vertices(a: Mesh, b: Mesh, settings: SurfaceSettings | None = None) -> VertexMatch:
    """Find for every vertex of a mesh the point of another mesh that it corresponds to.

    Parameters
    ----------
    a, b : Mesh
        The same shape, nearly: in other poses, of other sizes, of other meshes. See `find_map`.
    settings : SurfaceSettings, optional

    Returns
    -------
    match : VertexMatch

    Raises
    ------
    MeshError
        If a mesh has no surface, or its eigenproblem cannot be solved.
    """
    return vertex_match(find_map(a, b, settings), b)


def match_with_points(
    a: Mesh, b: Mesh, faces: Indices, settings: SurfaceSettings | None = None
) -> tuple[VertexMatch, SurfacePoints]:
    """Match vertices and the centres of some faces; a worker process can be asked for it.

    Parameters
    ----------
    a, b : Mesh
        As for `match_vertices`.
    faces : (p,) array of int
        Of a.
    settings : SurfaceSettings, optional

    Returns
    -------
    match : VertexMatch
    centers : SurfacePoints
        The points of b for the centres of these faces.

    Raises
    ------
    MeshError
        If a mesh has no surface, or its eigenproblem cannot be solved.
    """
    shape_map = find_map(a, b, settings)
    centers = shape_map.points(a.faces[faces].astype(np.int64), np.full((len(faces), 3), 1 / 3))
    return vertex_match(shape_map, b), centers


def vertex_match(shape_map: ShapeMap, b: Mesh) -> VertexMatch:
    """Apply a map to the vertices of its first mesh, and say how good it is.

    Parameters
    ----------
    shape_map : ShapeMap
    b : Mesh
        Its second mesh.

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
    """‖CᵀC − I‖ / √k; see `VertexMatch`."""
    k = len(maps.to_a)
    return float(np.linalg.norm(maps.to_a.T @ maps.to_a - np.eye(k))) / math.sqrt(k)


def commutativity(maps: FunctionalMaps, eigenvalues_a: FloatArray, eigenvalues_b: FloatArray) -> float:
    """‖CΛ_b − Λ_a C‖ / ‖Λ_a C‖; see `VertexMatch`."""
    c, k = maps.to_a, len(maps.to_a)
    ours = eigenvalues_a[:k, None] * c
    return float(np.linalg.norm(c * eigenvalues_b[:k] - ours)) / max(float(np.linalg.norm(ours)), 1e-12)


def evidence(shape_map: ShapeMap) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Find what speaks against the match of each vertex of the copy of a.

    Parameters
    ----------
    shape_map : ShapeMap

    Returns
    -------
    returned : (n,) array
        How far off one comes back, in units of √area.
    stretched : (n,) array
        Mean change of the distances to the compared samples, in the same unit.
    images : (n, 3) array
        Where the vertices are mapped to, on the copy of b.
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
    """(n,) confidence at the vertices of the copy of a, and the distortion of areas."""
    returned, stretched, images = evidence(shape_map)
    odds = _CONSTANT - _RETURN_WEIGHT * returned - _STRETCH_WEIGHT * stretched
    before = face_areas(shape_map.a.mesh)
    after = face_areas(Mesh(images, shape_map.a.mesh.faces))
    return 1 / (1 + np.exp(-odds)), float(np.abs(after - before).sum() / before.sum())
