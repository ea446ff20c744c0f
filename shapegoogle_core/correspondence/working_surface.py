# SPDX-License-Identifier: MIT
"""A shape prepared for matching: a clean, connected copy at working resolution, with what a match needs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra

from shapegoogle_core.correspondence.loose_parts import largest_parts, tied, ties_between_parts
from shapegoogle_core.correspondence.orientation import oriented_faces
from shapegoogle_core.descriptors import log_heat_kernel_signature, wave_kernel_signature
from shapegoogle_core.descriptors.geodesics import surface_graph
from shapegoogle_core.laplacian import build_operator
from shapegoogle_core.mesh.checks import check_surface
from shapegoogle_core.mesh.measures import vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray, IntArray, Mesh
from shapegoogle_core.mesh.prolongation import vertex_prolongation
from shapegoogle_core.preprocessing import repair_mapped, resample
from shapegoogle_core.registration import farthest_points
from shapegoogle_core.spectral import Spectrum, operator_spectrum

__all__ = ["SurfaceSettings", "WorkingSurface", "working_surface"]

Indices = NDArray[np.int64]

# All lengths are in units of √area, all times in units of the area.
_HEAT_TIMES = np.geomspace(0.005, 0.3, 8)
# The k-th eigenvalue of a surface of unit area is about 4πk (Weyl), so the same energies suit all shapes.
_WAVE_ENERGIES = np.linspace(math.log(15), math.log(1000), 24)
_WAVE_SIGMA = 7 * float(_WAVE_ENERGIES[1] - _WAVE_ENERGIES[0])
# A point is a tip if none within this distance is farther from the rest of the shape.
_TIP_RADIUS = 0.12
_MOST_TIPS = 12


@dataclass(frozen=True)
class SurfaceSettings:
    """Resolution of the copies on which shapes are matched.

    Parameters
    ----------
    floor, budget : int
        Smallest and largest number of vertices.
    eigenpairs : int
        Size of the final functional map.
    samples : int
        Number of points on which the map is refined.
    compared : int
        Number of these points on which candidates are compared, by the distances between them.
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
        The mesh as given, repaired, in the position and scale of the copy.
    whole_faces : (M,) array of int
        Index in the mesh as given of each face of `whole`.
    spectrum : Spectrum
        Spectrum of the copy. Loose parts are tied together, so that only the first eigenvalue is 0.
    prolongation : (N, n) sparse array
        Carries values to the vertices of the mesh as given; rows of vertices that no face uses are empty.
    scale : float
        √area of the mesh as given: a unit of the copy in the unit of the mesh.
    normals : (n, 3) array
        Area-weighted normals of the oriented faces, outwards where the surface encloses a volume; 0 where
        faces cannot be oriented consistently.
    faces : (m, 3) array of int
        Faces of the copy, oriented consistently.
    outward : bool
        Whether the surface encloses a volume, so that inside and outside are known.
    samples : (s,) array of int
        Evenly spread vertices. The first k of them are evenly spread too, for every k.
    distances : (n, c) array
        Distances along the surface from all vertices to the first c samples.
    graph : (n, n) sparse array
        Graph along which distances are measured, see `surface_graph`.
    tips : (t,) array of int
        Positions of extremities in `samples`, the farthest first.
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
        """(c,) vertices with known distances to all others."""
        return self.samples[: self.distances.shape[1]]

    def distances_to(self, vertices: Indices) -> FloatArray:
        """Compute distances along the surface from all vertices to some.

        Parameters
        ----------
        vertices : (k,) array of int

        Returns
        -------
        distances : (n, k) array
        """
        sources, place = np.unique(vertices, return_inverse=True)
        return dijkstra(self.graph, directed=False, indices=sources)[place].T

    @property
    def waves(self) -> FloatArray:
        """(n, d) wave kernel signatures among the descriptors."""
        return self.descriptors[:, len(_HEAT_TIMES) :]

    @cached_property
    def apart(self) -> FloatArray:
        """(c, c) distances between the compared vertices."""
        return self.distances[self.compared]

    @cached_property
    def coordinates(self) -> FloatArray:
        """(k, 6) coefficients of the positions and the normals in the eigenfunctions."""
        values = np.concatenate([self.mesh.vertices, self.normals], axis=1)
        return np.asarray((self.spectrum.eigenvectors.T * self.spectrum.mass) @ values)


def working_surface(mesh: Mesh, settings: SurfaceSettings) -> WorkingSurface:
    """Prepare a mesh for matching.

    Parameters
    ----------
    mesh : Mesh
        Of any resolution. It may be open or have several parts.
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
    copy, kept = largest_parts(resample(repaired, settings.floor, settings.budget))
    if len(copy.vertices) < len(repaired.vertices) or not kept.all():
        place = np.full(len(place), -1)  # simplified, so vertices may have moved
    unit = math.sqrt(copy.area)
    copy = Mesh(copy.vertices / unit, copy.faces, mesh.name)
    matrix = vertex_prolongation(copy, centered, centered.vertices / unit, place)
    ties, lengths = ties_between_parts(copy)
    spectrum = operator_spectrum(tied(build_operator(copy), ties), settings.eigenpairs)
    faces, outward = oriented_faces(copy)
    samples = farthest_points(copy.vertices, min(settings.samples, len(copy.vertices)))
    compared = samples[: settings.compared]
    normals = vertex_normals(Mesh(copy.vertices, faces))
    graph = surface_graph(copy)
    # The parts that a tie joins have no other connection, so the sum adds up no two lengths.
    graph = sparse.csr_array(graph + sparse.coo_array((lengths, ties.T), shape=graph.shape))
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


def _tips(distances: FloatArray, mass: FloatArray) -> Indices:
    """Find samples whose mean distance to the surface is the largest around them (Hilaga et al. 2001)."""
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
