# SPDX-License-Identifier: MIT
"""Spectrum and words of a mesh as it is: computed on a clean copy, known at every one of its own vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from threadpoolctl import threadpool_limits

from shapegoogle_core.bags import bag_of_features
from shapegoogle_core.describing import channel_words, working_shape
from shapegoogle_core.mesh import Mesh, check_surface, repair_mapped
from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.mesh.resampling import simplify
from shapegoogle_core.model import ShapeModel
from shapegoogle_core.prolongation import vertex_prolongation
from shapegoogle_core.spectrum import Spectrum, compute_spectrum

__all__ = ["VertexSpectrum", "VertexWords", "vertex_spectrum", "vertex_words"]


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
    check_surface(mesh)
    repaired, place = repair_mapped(mesh)
    check_surface(repaired)
    simplified = budget is not None and len(repaired.vertices) > budget
    if budget is not None and simplified:
        copy = simplify(repaired, budget)
        check_surface(copy)
        matrix = vertex_prolongation(copy, mesh, mesh.vertices, np.full(len(mesh.vertices), -1))
    else:
        copy = repaired
        matrix = vertex_prolongation(copy, mesh, mesh.vertices, place)
    return VertexSpectrum(compute_spectrum(copy, k, laplacian), matrix, simplified)


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
    points = shape.placement.of(mesh.vertices)
    matrix = vertex_prolongation(shape.mesh, mesh, points, np.full(len(points), -1))
    return VertexWords(words, matrix, bag_of_features(words, shape.spectrum.mass))
