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

from shapegoogle_core.mesh.mesh import FloatArray
from shapegoogle_core.registration.measures.moments import (
    FULL,
    full,
    full_cubic,
    octants,
    upper,
    upper_cubic,
    volume,
)

__all__ = ["ROUNDING", "WAVELENGTHS", "MeshMeasures", "stacked_moments"]

WAVELENGTHS = 8e-3 / 4.0 ** np.arange(3)
"""Wavelengths of the spectra, in units of √area; each is a quarter of the last."""

ROUNDING = 2.0**-24
"""Relative error of coordinates: most files round them to single precision."""

# Error of a product or a volume where coordinates have an error of 1.
_HANDED_ERROR = 100.0
_HEADER = struct.Struct("<QQQ")
_COUNT = 44 + 4 * len(WAVELENGTHS)


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
        How much more of the mesh is right-handed than left-handed, from −1 to 1; see `measure_mesh`.
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
        farthest = self.rounding / ROUNDING + float(np.linalg.norm(center)) / (scale * self.unit)
        return replace(
            self,
            hash=0,
            corners=np.full_like(self.corners, np.nan),
            area=scale**2 * self.area,
            rounding=farthest * ROUNDING,
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
