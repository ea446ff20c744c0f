# SPDX-License-Identifier: MIT
"""Measures of a mesh as it was read, which tell copies from other shapes without an alignment.

A sample of a few hundred points misses what lies between them: a hole of 7 mm instead of 6 mm, a sheet that
is a tenth longer. Integrals over all triangles do not. Two groups of numbers are kept:

- **Of the surface**: area and moments, of the points and of the normals. They are the same for every
  triangulation of a surface, but for the distance between a curved surface and its triangles.
- **Of the mesh**: spectra of the lengths of the edges, Σ cos(2π l / λ) and Σ sin(2π l / λ). They are the same
  for a copy with its vertices and faces in any order, in any place, and for its mirror image; a single vertex
  that has moved by a fraction of λ changes them.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["WAVELENGTHS", "MeshMeasures", "full", "measure_mesh", "stacked_moments"]

# Longest wavelength of the spectra, and their number; each is a quarter of the last.
_LONGEST, _QUARTERS = 8e-3, 3
WAVELENGTHS = _LONGEST / 4.0 ** np.arange(_QUARTERS)
"""Wavelengths of the spectra, in units of √area."""

# Edges with a smaller angle between their faces belong to a curved surface, others are meant to be sharp.
_SHARPEST = np.radians(40)
# ... and those with a smaller one to a flat side, but for rounding.
_FLATTEST = 1e-3
# Coordinates are rounded to single precision by most files.
_ROUNDING = 2.0**-24
_HEADER = struct.Struct("<QQQ")
_COUNT = 30 + 2 * len(WAVELENGTHS)
# Third moments below this vanish but for rounding, so that they have no direction.
_LEAST_THIRD = 1e-3


@dataclass(frozen=True, eq=False)
class MeshMeasures:
    """Measures of a mesh; see the text of the module.

    Attributes
    ----------
    vertex_count, face_count : int
    hash : int
        Sum of 64-bit hashes of all faces, from their corners in single precision: equal for the same
        triangles in the same place, whatever their order.
    area : float
    rounding : float
        Error of a coordinate in single precision, in units of √area.
    coarseness : float
        Rough share of the area that a smooth surface through the vertices would have more: the mean of θ²/24
        with θ the angle between two faces. 0 for a flat-sided part, infinite for a point cloud.
    curved : float
        Share of the area next to edges at which a curved surface bends, from 0 to 1: by more than a rounding
        error, and by less than at a sharp edge. Small for a flat-sided part, 1 for a point cloud.
    center : (3,) array
        Centre of mass of the surface.
    second, normals : (6,) arrays
        Upper triangles of the mean of x xᵀ, with x relative to the centre, and of n nᵀ.
    third : (3,) array
        Mean of x |x|².
    twist : (6,) array
        Upper triangle of the symmetric part of the mean of (x × n) nᵀ, which changes sign under reflection.
    fourth, support : float
        Means of |x|⁴ and of (x · n)².
    spectra : (2 w,) array
        Cosines and sines of the edges' lengths. Of a point cloud: of the distances to the nearest point.
    """

    vertex_count: int
    face_count: int
    hash: int
    area: float
    rounding: float
    coarseness: float
    curved: float
    center: FloatArray
    second: FloatArray
    normals: FloatArray
    third: FloatArray
    twist: FloatArray
    fourth: float
    support: float
    spectra: FloatArray

    @property
    def unit(self) -> float:
        """Length that all moments refer to: √area."""
        return float(np.sqrt(self.area))

    @cached_property
    def moments(self) -> FloatArray:
        """(8,) measures of the surface that do not depend on place and size: eigenvalues, fourth, support."""
        return np.asarray(stacked_moments([self])[0])

    @cached_property
    def handedness(self) -> FloatArray:
        """(4,) measures that change sign under reflection; 0 for a surface that is its own mirror image."""
        second, normals, twist = full(self.second), full(self.normals), full(self.twist)
        bent = second @ self.third
        return np.array(
            [
                _volume(self.third, bent, second @ bent),
                _volume(self.third, bent, normals @ self.third),
                (twist * second).sum(),
                (twist * normals).sum(),
            ]
        )

    def moved(self, matrix: FloatArray) -> MeshMeasures:
        """Return the measures of the mesh after a similarity transformation.

        Parameters
        ----------
        matrix : (4, 4) array
            Rotation or reflection, times a scale, and a translation.

        Returns
        -------
        measures : MeshMeasures
            Without a hash of its own, so that only the other measures are compared.
        """
        linear = np.asarray(matrix, np.float64)[:3, :3]
        scale = float(np.cbrt(abs(np.linalg.det(linear))))
        turn = linear / scale
        center = linear @ self.center + matrix[:3, 3]
        farthest = self.rounding / _ROUNDING + float(np.linalg.norm(center)) / (scale * self.unit)
        return replace(
            self,
            hash=0,
            area=scale**2 * self.area,
            rounding=farthest * _ROUNDING,
            center=center,
            second=_upper(turn @ full(self.second) @ turn.T),
            normals=_upper(turn @ full(self.normals) @ turn.T),
            third=turn @ self.third,
            twist=_upper(np.linalg.det(turn) * turn @ full(self.twist) @ turn.T),
        )

    def to_bytes(self) -> bytes:
        """Serialise.

        Returns
        -------
        data : bytes
        """
        numbers = [self.area, self.rounding, self.coarseness, self.curved, self.fourth, self.support]
        arrays = [self.center, self.second, self.normals, self.third, self.twist, self.spectra]
        header = _HEADER.pack(self.vertex_count, self.face_count, self.hash)
        return header + np.concatenate([numbers, *arrays]).astype("<f8").tobytes()

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Rebuild measures from `to_bytes`.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        measures : MeshMeasures

        Raises
        ------
        ValueError
            If the data has another length.
        """
        expected = _HEADER.size + 8 * _COUNT
        if len(data) != expected:
            raise ValueError(f"measures have {expected} bytes, not {len(data)}")
        values = np.frombuffer(data, "<f8", offset=_HEADER.size).astype(np.float64)
        area, rounding, coarseness, curved, fourth, support = values[:6].tolist()
        vertices, faces, hashed = _HEADER.unpack_from(data)
        counts = int(vertices), int(faces), int(hashed)
        starts, ends = (6, 9, 15, 21, 24, 30), (9, 15, 21, 24, 30, _COUNT)
        parts = (values[start:end] for start, end in zip(starts, ends, strict=True))
        center, second, normals, third, twist, spectra = parts
        return cls(
            *counts,
            area,
            rounding,
            coarseness,
            curved,
            center,
            second,
            normals,
            third,
            twist,
            fourth,
            support,
            spectra,
        )


def measure_mesh(mesh: Mesh) -> MeshMeasures | None:
    """Measure a mesh.

    Parameters
    ----------
    mesh : Mesh
        As it was read; a point cloud is measured by its points.

    Returns
    -------
    measures : MeshMeasures or None
        None if it has no area, or a cloud no extent.
    """
    corners = mesh.vertices[:, None] if mesh.is_point_cloud else mesh.vertices[mesh.faces]
    points = corners.reshape(-1, 3)
    if len(points) == 0:
        return None
    origin = (points.min(axis=0) + points.max(axis=0)) / 2
    if mesh.is_point_cloud:
        area = float((np.ptp(points, axis=0) ** 2).sum())
        lengths, _ = cKDTree(points).query(points, min(2, len(points)))
        lengths = np.asarray(lengths).reshape(len(points), -1)[:, -1]
        normals = np.zeros((len(corners), 3))
        weights, coarseness, curved = np.full(len(corners), area / len(corners)), np.inf, 1.0
    else:
        sides = corners - np.roll(corners, -1, axis=1)
        lengths = np.sqrt((sides**2).sum(axis=2)).ravel()
        normals = np.cross(sides[:, 0], sides[:, 1])
        weights = np.linalg.norm(normals, axis=1)
        normals /= np.maximum(weights, np.finfo(float).tiny)[:, None]
        weights /= 2
        area = float(weights.sum())
        coarseness, curved = _bending(mesh, normals, weights) if area > 0 else (0.0, 0.0)
    if not area > 0:
        return None
    unit = np.sqrt(area)
    mean, second, third, twist, fourth, support = _moments((corners - origin) / unit, normals, weights / area)
    wave = np.exp(2j * np.pi / _LONGEST / unit * lengths)
    sums = []
    for _ in range(_QUARTERS):
        sums.append(wave.sum())
        wave = np.square(np.square(wave))
    return MeshMeasures(
        len(mesh.vertices),
        len(mesh.faces),
        _hash(corners),
        area,
        float(np.abs(points).max() / unit * _ROUNDING),
        coarseness,
        curved,
        origin + unit * mean,
        second,
        _upper((weights / area * normals.T) @ normals),
        third,
        twist,
        fourth,
        support,
        np.concatenate([np.real(sums), np.imag(sums)]),
    )


def _moments(
    corners: FloatArray, normals: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float, float]:
    """Integrate polynomials over triangles, exactly up to degree 4."""
    if corners.shape[1] == 1:
        nodes, shares = np.ones((1, 1)), np.ones(1)
    else:
        nodes, shares = _QUADRATURE
    mean = (weights @ corners.mean(axis=1)).astype(np.float64)
    corners = corners - mean
    arms = np.cross(corners.mean(axis=1), normals)
    twist = (weights * arms.T) @ normals
    second, third, fourth, support = np.zeros((3, 3)), np.zeros(3), 0.0, 0.0
    for node, share in zip(nodes, shares, strict=True):
        points = node @ corners
        weighted = share * weights
        squares = (points**2).sum(axis=1)
        second += (weighted * points.T) @ points
        third += (weighted * squares) @ points
        fourth += float(weighted @ squares**2)
        support += float(weighted @ (points * normals).sum(axis=1) ** 2)
    return mean, _upper(second), third, _upper((twist + twist.T) / 2), fourth, support


def _quadrature() -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of the rule of six points that is exact to degree 4 (Dunavant 1985)."""
    nodes, shares = [], []
    for place, share in ((0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322)):
        for corner in range(3):
            node = np.full(3, place)
            node[corner] = 1 - 2 * place
            nodes.append(node)
            shares.append(share)
    return np.array(nodes), np.array(shares)


_QUADRATURE = _quadrature()


def _bending(mesh: Mesh, normals: FloatArray, weights: FloatArray) -> tuple[float, float]:
    vertices = _places(mesh.vertices)[mesh.faces]
    start, end = vertices.ravel(), np.roll(vertices, -1, axis=1).ravel()
    keys = np.minimum(start, end) * len(mesh.vertices) + np.maximum(start, end)
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(np.diff(keys[order]) == 0)
    one, other = order[same] // 3, order[same + 1] // 3
    cosines = np.abs((normals[one] * normals[other]).sum(axis=1))
    angles = np.arccos(np.minimum(cosines, 1))
    areas = (weights[one] + weights[other]) / weights.sum()
    areas[angles >= _SHARPEST] = 0
    return float((angles**2 / 24 * areas).sum()), float(areas[angles > _FLATTEST].sum() / 3)


def _places(points: FloatArray) -> NDArray[np.int64]:
    """Give points with the same coordinates the same number."""
    _, numbers = np.unique(_mixed((points + 0.0).view(np.uint64)), return_inverse=True)
    return numbers.astype(np.int64)


def _mixed(columns: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Hash rows of three numbers to 64 bits each (the finaliser of splitmix64)."""
    hashed = np.zeros(len(columns), np.uint64)
    with np.errstate(over="ignore"):
        for column in columns.T:
            hashed = (hashed + column + np.uint64(0x9E3779B97F4A7C15)) * np.uint64(0xBF58476D1CE4E5B9)
            hashed ^= hashed >> np.uint64(27)
            hashed *= np.uint64(0x94D049BB133111EB)
            hashed ^= hashed >> np.uint64(31)
    return hashed


def _hash(corners: FloatArray) -> int:
    """Sum of the hashes of all triangles; their order, their first corners and orientations do not matter."""
    single = corners.reshape(-1, 3).astype(np.float32) + np.float32(0)
    hashed = np.sort(_mixed(single.view(np.uint32).astype(np.uint64)).reshape(len(corners), -1), axis=1)
    if hashed.shape[1] == 1:
        hashed = np.repeat(hashed, 3, axis=1)
    with np.errstate(over="ignore"):
        return int(_mixed(hashed).sum(dtype=np.uint64))


def _volume(*vectors: FloatArray) -> float:
    """Volume of a parallelepiped relative to its longest edges, or 0 where an edge vanishes."""
    lengths = np.array([np.linalg.norm(vector) for vector in vectors])
    if lengths[0] < _LEAST_THIRD or lengths.min() == 0:
        return 0.0
    return float(
        np.linalg.det(np.stack([vector / length for vector, length in zip(vectors, lengths, strict=True)]))
    )


def stacked_moments(measures: Sequence[MeshMeasures]) -> FloatArray:
    """Compute `MeshMeasures.moments` of several meshes at once.

    Parameters
    ----------
    measures : sequence of n MeshMeasures

    Returns
    -------
    moments : (n, 8) array
    """
    matrices = np.array([(own.second, own.normals) for own in measures]).reshape(-1, 2, 6)
    roots = np.linalg.eigvalsh(matrices[..., _FULL].reshape(-1, 2, 3, 3))
    others = np.array([(own.fourth, own.support) for own in measures]).reshape(-1, 2)
    return np.concatenate([roots.reshape(-1, 6), others], axis=1)


# Places in an upper triangle of the entries of its matrix, row by row.
_FULL = [0, 1, 2, 1, 3, 4, 2, 4, 5]


def full(upper: FloatArray) -> FloatArray:
    """Return the symmetric matrix of an upper triangle.

    Parameters
    ----------
    upper : (6,) array

    Returns
    -------
    matrix : (3, 3) array
    """
    return np.asarray(np.asarray(upper)[_FULL].reshape(3, 3))


def _upper(matrix: FloatArray) -> FloatArray:
    return np.asarray(matrix[np.triu_indices(3)])
