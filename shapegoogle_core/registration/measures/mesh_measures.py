# SPDX-License-Identifier: MIT
"""Measures of a mesh as it was read, which tell copies from other shapes without an alignment.

A sample of a few hundred points misses what lies between them: a hole of 7 mm instead of 6 mm, a sheet that
is a tenth longer. Integrals over all triangles do not. Two groups of numbers are kept:

- **Of the surface**: area and moments, of the points and of the normals. They are the same for every
  triangulation of a surface, but for the distance between a curved surface and its triangles.
- **Of the mesh**: spectra of the lengths of the edges, Σ cos(2π l / λ) and Σ sin(2π l / λ). They are the same
  for a copy with its vertices and faces in any order, in any place, and for its mirror image; a single vertex
  that has moved by a fraction of λ changes them. Those of the corners along fixed directions u,
  Σ cos(2π u·x / λ) and Σ sin(2π u·x / λ), are the same only for a copy in the same place: a gear that is
  turned by a part of a tooth still has the same moments.
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
from shapegoogle_core.registration.measures.moments import (
    FULL,
    full,
    full_cubic,
    octants,
    surface_moments,
    upper,
    upper_cubic,
    volume,
)

__all__ = ["WAVELENGTHS", "MeshMeasures", "measure_mesh", "stacked_moments"]

# Longest wavelength of the spectra, and their number; each is a quarter of the last.
_LONGEST, _QUARTERS = 8e-3, 3
WAVELENGTHS = _LONGEST / 4.0 ** np.arange(_QUARTERS)
"""Wavelengths of the spectra, in units of √area."""

# Edges with a smaller angle between their faces belong to a curved surface, others are meant to be sharp.
_SHARPEST = np.radians(40)
# ... and those with a smaller one to a flat side, but for rounding.
_FLATTEST = 1e-3
# Error of a product or a volume where coordinates have an error of 1.
_HANDED_ERROR = 100.0
# Sums of products below this are those of rounding errors.
_LEAST_PRODUCT = 1e-6
# Coordinates are rounded to single precision by most files.
_ROUNDING = 2.0**-24
_HEADER = struct.Struct("<QQQ")
_COUNT = 44 + 4 * len(WAVELENGTHS)
# Directions of the spectra of corners, one for each wavelength: of unit length, and along no edge of a box.
_ALONG = np.array([[0.62, 0.35, 0.70], [-0.41, 0.87, 0.27], [0.53, -0.29, 0.80]])
_ALONG /= np.linalg.norm(_ALONG, axis=1, keepdims=True)


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
    cubic : (10,) array
        Mean of x_i x_j x_k for i ≤ j ≤ k.
    twist : (6,) array
        Upper triangle of the symmetric part of the mean of (x × n) nᵀ, which changes sign under reflection.
    swirl : (6,) array
        The same of (x · n) x (x × n)ᵀ.
    fourth, support : float
        Means of |x|⁴ and of (x · n)².
    chirality : float
        How much more of the mesh is right-handed than left-handed, from −1 to 1; see `_chirality`.
    spectra : (2 w,) array
        Cosines and sines of the edges' lengths. Of a point cloud: of the distances to the nearest point.
    corners : (2 w,) array
        Cosines and sines of the corners' coordinates relative to the centre, each wavelength along a
        direction of its own. NaN where they are not known.
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
    cubic: FloatArray
    twist: FloatArray
    swirl: FloatArray
    fourth: float
    support: float
    chirality: float
    spectra: FloatArray
    corners: FloatArray

    @property
    def unit(self) -> float:
        """Length that all moments refer to: √area."""
        return float(np.sqrt(self.area))

    @cached_property
    def moments(self) -> FloatArray:
        """(8,) measures of the surface that do not depend on place and size: eigenvalues, fourth, support."""
        return np.asarray(stacked_moments([self])[0])

    @cached_property
    def third(self) -> FloatArray:
        """(3,) mean of x |x|²."""
        return np.asarray(np.einsum("ijj->i", full_cubic(self.cubic)))

    @cached_property
    def handedness(self) -> FloatArray:
        """(8, 2) measures that change sign under reflection, and their errors.

        The measures are 0 for a surface that is its own mirror image: the mean of the product of the
        coordinates along the principal axes of the points, and along those of the normals; volumes that
        vectors span; products of twist and swirl with second and normals. An error is that where coordinates
        have an error of 1.
        """
        second, normals = full(self.second), full(self.normals)
        bent = second @ self.third
        others = [
            volume(self.third, bent, second @ bent),
            volume(self.third, bent, normals @ self.third),
            *((full(each) * other).sum() for each in (self.twist, self.swirl) for other in (second, normals)),
        ]
        along = [octants(self.cubic, matrix) for matrix in (second, normals)]
        return np.array([*along, *((value, _HANDED_ERROR) for value in others)])

    def moved(self, matrix: FloatArray) -> MeshMeasures:
        """Return the measures of the mesh after a similarity transformation.

        Parameters
        ----------
        matrix : (4, 4) array
            Rotation or reflection, times a scale, and a translation.

        Returns
        -------
        measures : MeshMeasures
            Without a hash and spectra of corners, so that only the other measures are compared.
        """
        linear = np.asarray(matrix, np.float64)[:3, :3]
        scale = float(np.cbrt(abs(np.linalg.det(linear))))
        turn = linear / scale
        center = linear @ self.center + matrix[:3, 3]
        farthest = self.rounding / _ROUNDING + float(np.linalg.norm(center)) / (scale * self.unit)
        return replace(
            self,
            hash=0,
            corners=np.full_like(self.corners, np.nan),
            area=scale**2 * self.area,
            rounding=farthest * _ROUNDING,
            center=center,
            second=upper(turn @ full(self.second) @ turn.T),
            normals=upper(turn @ full(self.normals) @ turn.T),
            cubic=upper_cubic(np.einsum("ai,bj,ck,ijk->abc", turn, turn, turn, full_cubic(self.cubic))),
            twist=upper(np.linalg.det(turn) * turn @ full(self.twist) @ turn.T),
            swirl=upper(np.linalg.det(turn) * turn @ full(self.swirl) @ turn.T),
            chirality=float(np.sign(np.linalg.det(turn))) * self.chirality,
        )

    def to_bytes(self) -> bytes:
        """Serialise.

        Returns
        -------
        data : bytes
        """
        numbers = [self.area, self.rounding, self.coarseness, self.curved]
        numbers += [self.fourth, self.support, self.chirality]
        arrays = [self.center, self.second, self.normals, self.cubic, self.twist, self.swirl]
        arrays += [self.spectra, self.corners]
        header = _HEADER.pack(self.vertex_count, self.face_count, self.hash)
        return header + np.concatenate([numbers, *arrays]).astype("<f8").tobytes()

    @classmethod
    def from_bytes(cls, data: bytes) -> Self | None:
        """Rebuild measures from `to_bytes`.

        Parameters
        ----------
        data : bytes

        Returns
        -------
        measures : MeshMeasures or None
            None if the data has another length, as those of another version of Shape Google.
        """
        if len(data) != _HEADER.size + 8 * _COUNT:
            return None
        values = np.frombuffer(data, "<f8", offset=_HEADER.size).astype(np.float64)
        area, rounding, coarseness, curved, fourth, support, chirality = values[:7].tolist()
        vertices, faces, hashed = _HEADER.unpack_from(data)
        counts = int(vertices), int(faces), int(hashed)
        lengths = (3, 6, 6, 10, 6, 6, 2 * len(WAVELENGTHS), 2 * len(WAVELENGTHS))
        parts = np.split(values[7:], np.cumsum(lengths)[:-1])
        center, second, normals, cubic, twist, swirl, spectra, corners = parts
        return cls(
            *counts,
            area,
            rounding,
            coarseness,
            curved,
            center,
            second,
            normals,
            cubic,
            twist,
            swirl,
            fourth,
            support,
            chirality,
            spectra,
            corners,
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
        normals, uses = np.zeros((len(corners), 3)), np.ones(len(points))
        weights, coarseness, curved = np.full(len(corners), area / len(corners)), np.inf, 1.0
    else:
        uses = np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices)).astype(float)
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
    relative = np.ascontiguousarray(((corners - origin) / unit).transpose(1, 2, 0))
    moments = surface_moments(relative, np.ascontiguousarray(normals.T), weights / area)
    wave = np.exp(2j * np.pi / _LONGEST / unit * lengths)
    sums = []
    for _ in range(_QUARTERS):
        sums.append(wave.sum())
        wave = np.square(np.square(wave))
    along = ((mesh.vertices - origin) / unit - moments.mean) @ _ALONG.T
    placed = uses @ np.exp(2j * np.pi / WAVELENGTHS * along)
    return MeshMeasures(
        len(mesh.vertices),
        len(mesh.faces),
        _hash(mesh),
        area,
        float(np.abs(points).max() / unit * _ROUNDING),
        coarseness,
        curved,
        origin + unit * moments.mean,
        moments.second,
        upper((weights / area * normals.T) @ normals),
        moments.cubic,
        moments.twist,
        moments.swirl,
        moments.fourth,
        moments.support,
        _chirality(relative - moments.mean[:, None]),
        np.concatenate([np.real(sums), np.imag(sums)]),
        np.concatenate([placed.real, placed.imag]),
    )


def _chirality(corners: FloatArray) -> float:
    """Compare the right-handed triangles of a mesh with the left-handed ones.

    A triangle counts with the determinant of its corners, in the order of their distances from the centre:
    Σ q / Σ |q| with q = det(a, b, c) (|a| − |b|)(|b| − |c|)(|c| − |a|), divided by all the lengths in it. It
    does not depend on the order in which a file has the corners.

    Parameters
    ----------
    corners : (3, 3, f) array
        Corners and their coordinates relative to the centre; for a point cloud (1, 3, f).

    Returns
    -------
    chirality : float
        Its negative for the mirror image; 0 for a mesh that is its own mirror image, and for a point cloud.
    """
    if len(corners) != 3:
        return 0.0
    first, second, third = corners
    away = np.sqrt((corners**2).sum(axis=1))
    sides = np.sqrt(((corners - np.roll(corners, -1, axis=0)) ** 2).sum(axis=1))
    lengths = np.prod(away * sides, axis=0)
    determinants = (
        first[0] * (second[1] * third[2] - second[2] * third[1])
        + first[1] * (second[2] * third[0] - second[0] * third[2])
        + first[2] * (second[0] * third[1] - second[1] * third[0])
    )
    products = determinants * np.prod(away - np.roll(away, -1, axis=0), axis=0)
    products /= np.where(lengths > 0, lengths, 1)
    total = np.abs(products).sum()
    return float(products.sum() / total) if total > _LEAST_PRODUCT else 0.0


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


def _hash(mesh: Mesh) -> int:
    """Sum of the hashes of all triangles; their order, their first corners and orientations do not matter."""
    with np.errstate(over="ignore"):
        single = mesh.vertices.astype(np.float32) + np.float32(0)
    mixed = _mixed(single.view(np.uint32).astype(np.uint64))
    faces = np.repeat(mixed[:, None], 3, axis=1) if mesh.is_point_cloud else mixed[mesh.faces]
    with np.errstate(over="ignore"):
        return int(_mixed(np.sort(faces, axis=1)).sum(dtype=np.uint64))


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
    roots = np.linalg.eigvalsh(matrices[..., FULL].reshape(-1, 2, 3, 3))
    others = np.array([(own.fourth, own.support) for own in measures]).reshape(-1, 2)
    return np.concatenate([roots.reshape(-1, 6), others], axis=1)
