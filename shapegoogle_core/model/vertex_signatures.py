# SPDX-License-Identifier: MIT
"""Spectrum, words and keypoints at the vertices of a mesh as it is, computed on a clean copy of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree
from threadpoolctl import threadpool_limits

from shapegoogle_core.api.arguments import check_count
from shapegoogle_core.keypoints import detect_keypoints
from shapegoogle_core.mesh import Mesh, MeshLike, as_mesh
from shapegoogle_core.mesh.checks import check_surface
from shapegoogle_core.mesh.connectivity import edge_graph
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

# Radius of the spots that show keypoints, as a share of √area: a little less than the width of a horse's leg.
SPOT_RADIUS = 0.045


@dataclass(frozen=True, eq=False)
class VertexSpectrum:
    """Spectrum of a clean copy of a mesh, and the prolongation to the vertices of the mesh.

    Attributes
    ----------
    spectrum : Spectrum
        Spectrum of the copy, which has m vertices.
    prolongation : (n, m) sparse array
        Carries values from the copy to the n vertices of the mesh: ``prolongation @ values``. The rows of
        loose vertices, which no face uses, are empty; all others sum to 1.
    simplified : bool
        Whether the copy has fewer vertices because of the budget. If not, values are carried unchanged.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> found = sg.vertex_spectrum(trimesh.creation.icosphere(), k=10)
    >>> signature = sg.heat_kernel_signature(found.spectrum, [0.1, 0.2])
    >>> found.carry(signature).shape
    (642, 2)
    """

    spectrum: Spectrum
    prolongation: csr_array
    simplified: bool

    def carry(self, values: FloatArray) -> FloatArray:
        """Carry values from the clean copy to the vertices of the mesh.

        Parameters
        ----------
        values : (m,) or (m, d) array
            Values at the vertices of the copy.

        Returns
        -------
        carried : (n,) or (n, d) array
            0 at loose vertices.
        """
        return self.prolongation @ values

    def nearest(self, vertex: int) -> int | None:
        """Find the vertex of the copy that is nearest to a vertex of the mesh.

        Parameters
        ----------
        vertex : int
            Index of a vertex of the mesh.

        Returns
        -------
        nearest : int or None
            Index of a vertex of the copy; None for a loose vertex.
        """
        start, end = self.prolongation.indptr[vertex : vertex + 2]
        if start == end:
            return None
        return int(self.prolongation.indices[start + self.prolongation.data[start:end].argmax()])


@dataclass(frozen=True, eq=False)
class VertexWords:
    """Geometric words of a preprocessed mesh, and the prolongation to the vertices of the mesh as given.

    Attributes
    ----------
    words : (m, V) array
        θ(x) at the vertices of the preprocessed mesh (paper, equation 12).
    prolongation : (n, m) sparse array
        As in `VertexSpectrum`.
    bag : (V,) array
        Share of each word in the area of the shape; sums to 1 (paper, equation 13).

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> found = sg.vertex_words(sg.load_model(), trimesh.creation.icosphere())
    >>> found.weights().shape, found.heaviest.shape
    ((642, 40), (642,))
    """

    words: FloatArray
    prolongation: csr_array
    bag: FloatArray

    def weights(self, words: NDArray[np.int64] | None = None) -> FloatArray:
        """Compute soft weights at the vertices of the mesh.

        Parameters
        ----------
        words : (w,) array of int, optional
            Words to return; all by default.

        Returns
        -------
        weights : (n, w) array
            θ of those words. Over all words they sum to 1 at each vertex, and to 0 at a loose one.
        """
        return self.prolongation @ (self.words if words is None else self.words[:, words])

    @property
    def heaviest(self) -> NDArray[np.int64]:
        """(n,) word with the largest weight at each vertex of the mesh; −1 at loose vertices."""
        word = np.asarray(self.weights().argmax(axis=1), np.int64)
        word[np.diff(self.prolongation.indptr) == 0] = -1
        return word


@dataclass(frozen=True, eq=False)
class VertexKeypoints:
    """Keypoints among the vertices of a mesh.

    Attributes
    ----------
    indices : (p,) array of int
        Vertices of the mesh, the strongest first.
    response : (p,) array
        As in `Keypoints`.
    prolongation : (n, m) sparse array
        As in `VertexSpectrum`.
    strength, coverage : (m,) array
        Spots around the keypoints on the clean copy, which show them where a single vertex is too small: the
        response of the nearest keypoint along the surface, relative to the strongest one; and a value that
        falls from 1 at the keypoint to 0 at the edge of its spot.
    simplified : bool
        As in `VertexSpectrum`.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> ellipsoid = trimesh.creation.icosphere().apply_scale([1, 1.2, 3])
    >>> found = sg.vertex_keypoints(ellipsoid, k=30)
    >>> len(found), found.responses.shape
    (2, (642,))
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
        """(n,) response at each vertex of the mesh; 0 at vertices that are not keypoints."""
        values = np.zeros(self.prolongation.shape[0])
        values[self.indices] = self.response
        return values


def vertex_spectrum(
    mesh: MeshLike, k: int = 100, laplacian: str = "robust", budget: int | None = None
) -> VertexSpectrum:
    """Compute the spectrum of a mesh in any state of repair, for its own vertices.

    Duplicate vertices are welded and faces without area dropped first (see `repair`), so that heat crosses
    seams. A clean mesh has the vertices of its spectrum, in the same order.

    Parameters
    ----------
    mesh : MeshLike
        A surface as read.
    k : int, optional
        Number of eigenpairs.
    laplacian : str, optional
        See `compute_spectrum`.
    budget : int, optional
        Maximum number of vertices: a finer mesh is simplified first. By default no mesh is.

    Returns
    -------
    spectrum : VertexSpectrum

    Raises
    ------
    ValueError
        If k or the budget is not a whole number, k < 1 or the budget < 4, or the Laplacian is unknown.
    MeshError
        If the mesh has no surface, or its eigenproblem cannot be solved.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> soup = trimesh.creation.icosphere().triangles.reshape(-1, 3)
    >>> found = sg.vertex_spectrum((soup, [[i, i + 1, i + 2] for i in range(0, len(soup), 3)]), k=10)
    >>> len(found.spectrum.mass), found.prolongation.shape
    (642, (3840, 642))
    """
    copy, matrix, simplified = _clean_copy(as_mesh(mesh), budget)
    return VertexSpectrum(compute_spectrum(copy, k, laplacian), matrix, simplified)


def vertex_keypoints(
    mesh: MeshLike,
    detector: str = "hks-maxima",
    k: int = 100,
    laplacian: str = "robust",
    budget: int | None = None,
) -> VertexKeypoints:
    """Find the keypoints of a mesh in any state of repair, among its own vertices.

    They are detected on the copy that `vertex_spectrum` makes, and moved to the nearest vertex of the mesh
    that belongs to a face. Of two keypoints at the same vertex the stronger one remains.

    Parameters
    ----------
    mesh : MeshLike
        A surface as read.
    detector : str, optional
        See `detect_keypoints`. Its parameters have their defaults.
    k, laplacian, budget : int, str, int, optional
        As in `vertex_spectrum`. The neighbourhoods that detectors compare grow with the square of the
        resolution, so a budget of some thousand vertices suits them.

    Returns
    -------
    keypoints : VertexKeypoints

    Raises
    ------
    ValueError
        If there is no such detector, or a parameter is out of range as in `vertex_spectrum`.
    MeshError
        If the mesh has no surface, or its eigenproblem cannot be solved.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> ellipsoid = trimesh.creation.icosphere().apply_scale([1, 1.2, 3])
    >>> found = sg.vertex_keypoints(ellipsoid, k=30)
    >>> sorted(float(z) for z in ellipsoid.vertices[found.indices, 2].round(2))
    [-3.0, 3.0]
    """
    mesh = as_mesh(mesh)
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


def vertex_words(model: ShapeModel, mesh: MeshLike, channel: int = 0) -> VertexWords:
    """Find the geometric words of a mesh, at its own vertices.

    Parameters
    ----------
    model : ShapeModel
        Model with the vocabulary.
    mesh : MeshLike
        A surface as read, of any resolution, size and state of repair.
    channel : int, optional
        Index of one of the model's channels.

    Returns
    -------
    words : VertexWords

    Raises
    ------
    ValueError
        If the model has no such channel.
    MeshError
        If the mesh has no surface, or the descriptor cannot be computed for it.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> import trimesh
    >>> found = sg.vertex_words(sg.load_model(), trimesh.creation.capsule(2.0, 0.5))
    >>> found.words.shape[1], round(float(found.bag.sum()), 6)
    (40, 1.0)
    """
    mesh = as_mesh(mesh)
    check_surface(mesh)
    settings = model.settings
    if channel not in range(len(settings.channels)):
        raise ValueError(f"channel must be from 0 to {len(settings.channels) - 1}, not {channel!r}")
    # One thread as in `ShapeModel.describe`, so that the words are exactly those of a search.
    with threadpool_limits(1, user_api="blas"):
        shape = working_shape(settings, mesh)
        words = channel_words(settings, channel, model.vocabularies[channel], shape)
    points = shape.placement.apply(mesh.vertices)
    matrix = vertex_prolongation(shape.mesh, mesh, points, np.full(len(points), -1))
    return VertexWords(words, matrix, bag_of_features(words, shape.spectrum.mass))


def _clean_copy(mesh: Mesh, budget: int | None) -> tuple[Mesh, csr_array, bool]:
    """Repair and perhaps simplify a mesh; return also the prolongation, and whether it was simplified."""
    if budget is not None:
        check_count("budget", budget, 4)
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
    """Return strength and coverage of spots around vertices, as in `VertexKeypoints`."""
    n = len(mesh.vertices)
    if not len(indices):
        return np.zeros(n), np.zeros(n)
    radius = SPOT_RADIUS * np.sqrt(mesh.area)
    distance, _, source = dijkstra(
        edge_graph(mesh),
        directed=False,
        indices=indices,
        min_only=True,
        limit=radius,
        return_predecessors=True,
    )
    of_vertex = np.zeros(n)
    of_vertex[indices] = response / response.max()
    near = np.isfinite(distance)
    strength = np.zeros(n)
    strength[near] = of_vertex[source[near]]
    return strength, np.where(near, 1 - np.minimum(distance, radius) / radius, 0.0)
