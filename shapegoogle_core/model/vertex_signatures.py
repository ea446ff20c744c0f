# SPDX-License-Identifier: MIT
"""Spectrum, words and keypoints of a mesh as it is: computed on a clean copy, known at its own vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree
from threadpoolctl import threadpool_limits

from shapegoogle_core.keypoints import detect_keypoints
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.mesh.checks import check_surface
from shapegoogle_core.mesh.connectivity import unique_edges
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.mesh.prolongation import vertex_prolongation
from shapegoogle_core.model.shape_bags import channel_words
from shapegoogle_core.model.shape_model import ShapeModel
from shapegoogle_core.model.working_shape import working_shape
from shapegoogle_core.preprocessing import repair_mapped
from shapegoogle_core.preprocessing.resampling import simplify
from shapegoogle_core.spectral import Spectrum, compute_spectrum
from shapegoogle_core.words import bag_of_features

__all__ = [
    "VertexKeypoints",
    "VertexSpectrum",
    "VertexWords",
    "vertex_keypoints",
    "vertex_spectrum",
    "vertex_words",
]

# Of the spots by which keypoints are seen, as a share of √area: a horse's leg is nearly as wide.
SPOT_RADIUS = 0.045


@dataclass(frozen=True, eq=False)
class VertexSpectrum:
    """Eigenpairs of a clean copy of a mesh, and the way back.

    Attributes
    ----------
    spectrum : Spectrum
        Of the copy, with m vertices.
    prolongation : (n, m) sparse array
        Carries values from the copy to the n vertices of the mesh: ``prolongation @ values``. The rows of
        loose vertices, which no face uses, are empty; all others sum to 1.
    simplified : bool
        Whether the copy has fewer vertices because of the budget. If not, values are carried unchanged.
    """

    spectrum: Spectrum
    prolongation: csr_array
    simplified: bool

    def carry(self, values: FloatArray) -> FloatArray:
        """Values on the clean copy, at the vertices of the mesh.

        Parameters
        ----------
        values : (m,) or (m, d) array

        Returns
        -------
        carried : (n,) or (n, d) array
            0 at loose vertices.
        """
        carried: FloatArray = self.prolongation @ values
        return carried

    def nearest(self, vertex: int) -> int | None:
        """Vertex of the copy that stands for a vertex of the mesh; None for a loose one."""
        start, end = self.prolongation.indptr[vertex : vertex + 2]
        if start == end:
            return None
        return int(self.prolongation.indices[start + self.prolongation.data[start:end].argmax()])


@dataclass(frozen=True, eq=False)
class VertexWords:
    """Geometric words of a mesh, and the way back from the mesh on which they were computed.

    Attributes
    ----------
    words : (m, V) array
        θ(x) at the vertices of the mended mesh.
    prolongation : (n, m) sparse array
        As in `VertexSpectrum`.
    bag : (V,) array
        Share of each word in the area of the shape; sums to 1 (paper, equation 13).
    """

    words: FloatArray
    prolongation: csr_array
    bag: FloatArray

    def weights(self, words: NDArray[np.int64] | None = None) -> FloatArray:
        """Soft weights at the vertices of the mesh.

        Parameters
        ----------
        words : (w,) array of int, optional
            Of which words; all when left out.

        Returns
        -------
        weights : (n, w) array
            θ of those words; over all words a vertex has 1, a loose one 0.
        """
        weights: FloatArray = self.prolongation @ (self.words if words is None else self.words[:, words])
        return weights

    @property
    def heaviest(self) -> NDArray[np.int64]:
        """(n,) word with the most weight at each vertex of the mesh; −1 at loose vertices."""
        word = np.asarray(self.weights().argmax(axis=1), np.int64)
        word[np.diff(self.prolongation.indptr) == 0] = -1
        return word


@dataclass(frozen=True, eq=False)
class VertexKeypoints:
    """Keypoints of a mesh, as vertices of its own.

    Attributes
    ----------
    indices : (p,) array of int
        Vertices of the mesh, the strongest first.
    response : (p,) array
        As in `Keypoints`.
    prolongation : (n, m) sparse array
        As in `VertexSpectrum`.
    strength, coverage : (m,) array
        Of spots around the keypoints, by which they are seen where a single vertex is too small, on the clean
        copy: the response of the nearest keypoint along the surface, as a share of the strongest; and 1 at
        the keypoint, 0 where none is near.
    simplified : bool
        As in `VertexSpectrum`.
    """

    indices: NDArray[np.int64]
    response: FloatArray
    prolongation: csr_array
    strength: FloatArray
    coverage: FloatArray
    simplified: bool

    def __len__(self) -> int:
        return len(self.indices)

    @property
    def responses(self) -> FloatArray:
        """(n,) response at each vertex of the mesh; 0 at all that are no keypoints."""
        values = np.zeros(self.prolongation.shape[0])
        values[self.indices] = self.response
        return values


def vertex_spectrum(
    mesh: Mesh, k: int = 100, laplacian: str = "robust", budget: int | None = None
) -> VertexSpectrum:
    """Compute the spectrum of a mesh in whatever state, for its own vertices.

    Vertices at one place are welded and faces without area dropped first (see `repair`), so that heat
    crosses seams. The vertices of a clean mesh are those of its spectrum, in the same order.

    Parameters
    ----------
    mesh : Mesh
    k : int
        Number of eigenpairs.
    laplacian : str
        See `compute_spectrum`.
    budget : int, optional
        A mesh of more vertices is simplified to that many first. Left out: none is.

    Returns
    -------
    spectrum : VertexSpectrum

    Raises
    ------
    MeshError
        If the mesh has no surface, or its eigenproblem cannot be solved.
    """
    copy, matrix, simplified = _clean_copy(mesh, budget)
    return VertexSpectrum(compute_spectrum(copy, k, laplacian), matrix, simplified)


def vertex_keypoints(
    mesh: Mesh,
    detector: str = "hks-maxima",
    k: int = 100,
    laplacian: str = "robust",
    budget: int | None = None,
) -> VertexKeypoints:
    """Find the keypoints of a mesh in whatever state, among its own vertices.

    They are detected on the copy that `vertex_spectrum` makes, and moved to the nearest vertex of the mesh
    that belongs to a face; of two that come to the same vertex the stronger remains.

    Parameters
    ----------
    mesh : Mesh
    detector : str
        See `detect_keypoints`. Its parameters have their defaults.
    k, laplacian, budget
        As in `vertex_spectrum`. Detectors look at discs whose size grows with the square of the resolution:
        a budget of some thousand vertices is what they are made for.

    Returns
    -------
    keypoints : VertexKeypoints

    Raises
    ------
    ValueError
        If there is no such detector.
    MeshError
        If the mesh has no surface, or its eigenproblem cannot be solved.
    """
    copy, matrix, simplified = _clean_copy(mesh, budget)
    found = detect_keypoints(copy, compute_spectrum(copy, k, laplacian), detector)
    used = np.unique(mesh.faces)
    _, near = KDTree(mesh.vertices[used]).query(copy.vertices[found.indices])
    vertices, first = np.unique(used[near], return_index=True)
    order = np.argsort(first)  # the strongest come first, and stay there
    strength, coverage = _spots(copy, found.indices, found.response)
    return VertexKeypoints(
        vertices[order], found.response[first[order]], matrix, strength, coverage, simplified
    )


def vertex_words(model: ShapeModel, mesh: Mesh, channel: int = 0) -> VertexWords:
    """Find the geometric words of a mesh, at its own vertices.

    Parameters
    ----------
    model : ShapeModel
    mesh : Mesh
        As read: any resolution, size and state of repair.
    channel : int
        Which of the model's channels.

    Returns
    -------
    words : VertexWords

    Raises
    ------
    MeshError
        If the mesh has no surface, or no such descriptor.
    """
    check_surface(mesh)
    settings = model.settings
    # As in `ShapeModel.describe`: the words are those that the search sees.
    with threadpool_limits(1, user_api="blas"):
        shape = working_shape(settings, mesh)
        words = channel_words(settings, channel, model.vocabularies[channel], shape)
    points = shape.placement.apply(mesh.vertices)
    matrix = vertex_prolongation(shape.mesh, mesh, points, np.full(len(points), -1))
    return VertexWords(words, matrix, bag_of_features(words, shape.spectrum.mass))


def _clean_copy(mesh: Mesh, budget: int | None) -> tuple[Mesh, csr_array, bool]:
    """Repair a mesh, and simplify it above a budget; with the way back, and whether it was simplified."""
    check_surface(mesh)
    repaired, place = repair_mapped(mesh)
    check_surface(repaired)
    if budget is None or len(repaired.vertices) <= budget:
        return repaired, vertex_prolongation(repaired, mesh, mesh.vertices, place), False
    copy = simplify(repaired, budget)
    check_surface(copy)
    anywhere = np.full(len(mesh.vertices), -1)
    return copy, vertex_prolongation(copy, mesh, mesh.vertices, anywhere), True


def _spots(mesh: Mesh, indices: NDArray[np.int64], response: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Strength and coverage, as in `VertexKeypoints`, of spots around vertices."""
    n = len(mesh.vertices)
    if not len(indices):
        return np.zeros(n), np.zeros(n)
    edges, _ = unique_edges(mesh)
    lengths = np.linalg.norm(np.diff(mesh.vertices[edges], axis=1)[:, 0], axis=1)
    radius = SPOT_RADIUS * np.sqrt(mesh.area)
    graph = csr_array((lengths, (edges[:, 0], edges[:, 1])), shape=(n, n))
    distance, _, source = dijkstra(
        graph, directed=False, indices=indices, min_only=True, limit=radius, return_predecessors=True
    )
    of_vertex = np.zeros(n)
    of_vertex[indices] = response / response.max()
    near = np.isfinite(distance)
    strength = np.zeros(n)
    strength[near] = of_vertex[source[near]]
    return strength, np.where(near, 1 - np.minimum(distance, radius) / radius, 0.0)
