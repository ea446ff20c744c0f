# SPDX-License-Identifier: MIT
"""Local heat: heat kernel signatures that a part has in common with its whole, in any pose.

The heat kernel K_t(x, x) at a short time t depends on the surface up to a few √t around x. So a part that is
cut off keeps its values but near the cut, and bending changes them little. They must be measured on the
surface as it is: smoothing, which removes more of a whole than of its part, would change thin limbs by
more than two individuals differ.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from shapegoogle_core.laplacian.cotangent import cotangent
from shapegoogle_core.mesh.connectivity import edge_graph
from shapegoogle_core.mesh.measures import vertex_normals
from shapegoogle_core.mesh.mesh import FloatArray, Mesh
from shapegoogle_core.preprocessing import Unsmoothed
from shapegoogle_core.registration.medial import medial_radii
from shapegoogle_core.spectral import Spectrum

__all__ = ["HEAT_TIMES", "LocalHeat", "measure_local_heat"]

HEAT_TIMES = 4e-3 * 2.0 ** np.arange(7)
"""Times as a share of the area, an octave apart. A hundred eigenpairs do not represent shorter ones. A part
needs longer ones than its whole: half as large, it has the value of its whole at twice the time."""

# Largest and smallest radius of a medial ball, as shares of √area.
_LARGEST_RADIUS, _SMALLEST_RADIUS = 0.5, 0.01
# Ranges of the stored numbers, in one byte each.
_RANGES = {
    "values": (-0.8, 4.4),
    "radii": (math.log(_SMALLEST_RADIUS), math.log(_LARGEST_RADIUS)),
    "margins": (0.0, 0.75),
}
_HEADER = struct.Struct("<HH")


@dataclass(frozen=True, eq=False)
class LocalHeat:
    """Local heat of the first points of a sample. Lengths are in units of √area of the unsmoothed surface.

    Attributes
    ----------
    values : (k, t) array of float32
        log 4πt K_t(x, x) at `HEAT_TIMES`: 0 on a plane, larger on a limb.
    radii : (k,) array of float32
        Logarithms of the radii of the medial balls, see `medial_radii`.
    margins : (k,) array of float32
        Distances to the open boundary and to lids of holes, 0.75 at most, which all points have if nothing is
        cut off; see `opening_points`.
    """

    values: NDArray[np.float32]
    radii: NDArray[np.float32]
    margins: NDArray[np.float32]

    @property
    def is_cut(self) -> bool:
        """Whether something is cut off the surface."""
        return bool((self.margins < _RANGES["margins"][1]).any())

    def first(self, points: int) -> Self:
        """Return the local heat of the first points only.

        Parameters
        ----------
        points : int

        Returns
        -------
        heat : LocalHeat
        """
        return type(self)(self.values[:points], self.radii[:points], self.margins[:points])

    def to_bytes(self) -> bytes:
        """Serialise with a byte for each number.

        Returns
        -------
        data : bytes
        """
        stored = []
        for name, (low, high) in _RANGES.items():
            share = (getattr(self, name) - low) / (high - low)
            stored.append(np.rint(255 * share).clip(0, 255).astype(np.uint8).tobytes())
        return _HEADER.pack(*self.values.shape) + b"".join(stored)

    @staticmethod
    def check(data: bytes) -> tuple[int, int]:
        """Check that data is local heat, which is faster than reading it.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        points, times : int
            Numbers k and t.

        Raises
        ------
        ValueError
            If it is not.
        """
        if len(data) < _HEADER.size:
            raise ValueError(f"local heat has at least {_HEADER.size} bytes")
        points, times = _HEADER.unpack_from(data)
        if times != len(HEAT_TIMES) or len(data) != _HEADER.size + points * (times + 2):
            raise ValueError(f"local heat of {points} points at {times} times cannot have {len(data)} bytes")
        return points, times

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Rebuild local heat from `to_bytes`.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        heat : LocalHeat
            Values to 0.01, margins to 0.0015, radii to 1 %.

        Raises
        ------
        ValueError
            If the data is not local heat.
        """
        points, times = cls.check(data)
        sizes = (points * times, points, points)
        arrays, start = {}, _HEADER.size
        for (name, (low, high)), size in zip(_RANGES.items(), sizes, strict=True):
            stored = np.frombuffer(data, np.uint8, size, start)
            arrays[name] = (low + (high - low) / 255 * stored).astype(np.float32)
            start += size
        arrays["values"] = arrays["values"].reshape(points, times)
        return cls(**arrays)

    def at_scale(self, scale: float) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Compute what a surface would have at another size.

        Parameters
        ----------
        scale : float
            Factor of all lengths, up to 1: 4πt K_t at this size is that at t/s² before. Times longer than the
            longest one have its value.

        Returns
        -------
        values, radii, margins : (k, t), (k,), (k,) arrays of float32
            As in the attributes.
        """
        if scale == 1:
            return self.values, self.radii, self.margins
        octaves = np.arange(len(HEAT_TIMES))
        places = (octaves - 2 * math.log2(scale)).clip(max=octaves[-1])
        values = CubicSpline(octaves, self.values, axis=1)(places).astype(np.float32)
        return values, self.radii + np.float32(math.log(scale)), np.float32(scale) * self.margins


def measure_local_heat(
    unsmoothed: Unsmoothed,
    spectrum: Spectrum,
    vertices: NDArray[np.int64],
    corners: FloatArray,
    count: int,
) -> LocalHeat:
    """Measure the local heat at points of a surface.

    The eigenfunctions φ of the smoothed surface span nearly the same space as those of the unsmoothed one.
    So that one's eigenproblem is solved in this space (Rayleigh and Ritz): ΦᵀWΦ c = λ ΦᵀAΦ c, with the
    stiffness W and the areas A of the unsmoothed surface. That takes a tenth of the time of another spectrum;
    at the shortest time the values differ by 0.01.

    Parameters
    ----------
    unsmoothed : Unsmoothed
    spectrum : Spectrum
        Of the mesh with the same vertices and faces that was made from it by smoothing.
    vertices : (n, 3) array of int
        Vertices of the faces of points that cover the surface densely.
    corners : (n, 3) array
        Barycentric coordinates of these.
    count : int
        Number k of the first of these points that are described.

    Returns
    -------
    heat : LocalHeat
    """
    mesh = unsmoothed.mesh
    unit = math.sqrt(mesh.area)
    weights = corners[:, :, None]
    points = (mesh.vertices[vertices] * weights).sum(axis=1) / unit
    described = vertices[:count], weights[:count]
    normals = (vertex_normals(mesh)[described[0]] * described[1]).sum(axis=1)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    radii = np.abs(medial_radii(points[:count], normals, points, _LARGEST_RADIUS))
    margins = (_distances_along(mesh, unsmoothed.openings)[described[0]] * corners[:count]).sum(axis=1) / unit
    operator = cotangent(mesh)
    basis = spectrum.eigenvectors
    stiffness = basis.T @ (operator.stiffness @ basis)
    mass = basis.T @ (operator.lumped_mass[:, None] * basis)
    eigenvalues, combinations = eigh(stiffness, mass)
    squares = ((basis[described[0]] * described[1]).sum(axis=1) @ combinations) ** 2
    decay = np.exp(-np.outer(eigenvalues.clip(min=0), HEAT_TIMES * unit**2))
    traces = 4 * np.pi * HEAT_TIMES * unit**2 * (squares @ decay)
    return LocalHeat(
        np.log(traces.clip(min=np.finfo(np.float32).tiny)).astype(np.float32),
        np.log(radii.clip(min=_SMALLEST_RADIUS)).astype(np.float32),
        margins.clip(max=_RANGES["margins"][1]).astype(np.float32),
    )


def _distances_along(mesh: Mesh, openings: FloatArray) -> FloatArray:
    """Measure the distance of each vertex from the openings along edges, up to 15 % too long."""
    if len(openings) == 0:
        return np.full(len(mesh.vertices), _RANGES["margins"][1] * math.sqrt(mesh.area))
    nearest = np.unique(cKDTree(mesh.vertices).query(openings)[1])
    farthest = 2 * _RANGES["margins"][1] * math.sqrt(mesh.area)
    found = dijkstra(edge_graph(mesh), directed=False, indices=nearest, min_only=True, limit=farthest)
    return np.asarray(found.clip(max=farthest), np.float64)
