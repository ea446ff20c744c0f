# SPDX-License-Identifier: MIT
"""Moments of a surface of triangles, exact up to degree 4, and products of them that show handedness."""

from __future__ import annotations

from itertools import combinations_with_replacement, product
from typing import NamedTuple

import numpy as np

from shapegoogle_core.mesh.mesh import FloatArray

__all__ = [
    "FULL",
    "LEAST_GAP",
    "SurfaceMoments",
    "full",
    "full_cubic",
    "octants",
    "surface_moments",
    "upper",
    "upper_cubic",
    "volume",
]

# Third moments below this vanish but for rounding, so that they have no direction.
_LEAST_THIRD = 1e-3
LEAST_GAP = 1e-3
"""Least difference of two eigenvalues whose eigenvectors are certain, relative to the largest one."""


class SurfaceMoments(NamedTuple):
    """Moments of a surface, as in `MeshMeasures`, about their mean."""

    mean: FloatArray
    second: FloatArray
    cubic: FloatArray
    twist: FloatArray
    swirl: FloatArray
    fourth: float
    support: float


def surface_moments(corners: FloatArray, normals: FloatArray, weights: FloatArray) -> SurfaceMoments:
    """Integrate polynomials over triangles, exactly up to degree 4."""
    if corners.shape[1] == 1:
        nodes, shares = np.ones((1, 1)), np.ones(1)
    else:
        nodes, shares = _QUADRATURE
    mean = (weights @ corners.mean(axis=1)).astype(np.float64)
    corners = corners - mean
    second, cubic = np.zeros((3, 3)), np.zeros((3, 3, 3))
    twist, swirl = np.zeros((3, 3)), np.zeros((3, 3))
    fourth, support = 0.0, 0.0
    for node, share in zip(nodes, shares, strict=True):
        points = node @ corners
        weighted = share * weights
        heights = (points * normals).sum(axis=1)
        arms = np.cross(points, normals)
        products = (points[:, :, None] * points[:, None, :]).reshape(-1, 9)
        second += (weighted * points.T) @ points
        cubic += ((weighted * points.T) @ products).reshape(3, 3, 3)
        twist += (weighted * arms.T) @ normals
        swirl += (weighted * heights * points.T) @ arms
        fourth += float(weighted @ (points**2).sum(axis=1) ** 2)
        support += float(weighted @ heights**2)
    return SurfaceMoments(
        mean,
        upper(second),
        upper_cubic(cubic),
        upper((twist + twist.T) / 2),
        upper((swirl + swirl.T) / 2),
        fourth,
        support,
    )


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


def volume(*vectors: FloatArray) -> float:
    """Volume of a parallelepiped relative to its longest edges, or 0 where an edge vanishes."""
    lengths = np.array([np.linalg.norm(vector) for vector in vectors])
    if lengths[0] < _LEAST_THIRD or lengths.min() == 0:
        return 0.0
    return float(
        np.linalg.det(np.stack([vector / length for vector, length in zip(vectors, lengths, strict=True)]))
    )


def octants(cubic: FloatArray, second: FloatArray) -> tuple[float, float]:
    """Compute how unevenly a surface lies in the octants of the eigenvectors of a matrix.

    Parameters
    ----------
    cubic : (10,) array
    second : (3, 3) array

    Returns
    -------
    mean : float
        Of x y z along the eigenvectors; 0 where two eigenvalues are hard to tell apart.
    error : float
        Its error where coordinates, and entries of the matrix, have an error of 1.
    """
    values, axes = np.linalg.eigh(second)
    gap = np.diff(values).min()
    if gap < LEAST_GAP * values[-1]:
        return 0.0, 1.0
    x, y, z = axes.T * np.sign(np.linalg.det(axes))
    mean = float(np.einsum("ijk,i,j,k", full_cubic(cubic), x, y, z))
    return mean, float(1 + 3 * np.abs(cubic).max() / gap)


# Places in an upper triangle of the entries of its matrix, row by row.
FULL = [0, 1, 2, 1, 3, 4, 2, 4, 5]


def full(entries: FloatArray) -> FloatArray:
    """Return the symmetric matrix of an upper triangle.

    Parameters
    ----------
    entries : (6,) array

    Returns
    -------
    matrix : (3, 3) array
    """
    return np.asarray(np.asarray(entries)[FULL].reshape(3, 3))


def upper(matrix: FloatArray) -> FloatArray:
    """Return the upper triangle (6,) of a symmetric matrix."""
    return np.asarray(matrix[np.triu_indices(3)])


_CUBIC: list[tuple[int, ...]] = list(combinations_with_replacement(range(3), 3))
_FULL_CUBIC = [_CUBIC.index(tuple(sorted(place))) for place in product(range(3), repeat=3)]


def full_cubic(entries: FloatArray) -> FloatArray:
    """Return the symmetric (3, 3, 3) array of its entries with i ≤ j ≤ k.

    Parameters
    ----------
    entries : (10,) array

    Returns
    -------
    cubic : (3, 3, 3) array
    """
    return np.asarray(np.asarray(entries)[_FULL_CUBIC].reshape(3, 3, 3))


def upper_cubic(cubic: FloatArray) -> FloatArray:
    """Return the entries (10,) with i ≤ j ≤ k of a symmetric (3, 3, 3) array."""
    return np.array([cubic[place] for place in _CUBIC])
