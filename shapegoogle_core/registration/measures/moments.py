# SPDX-License-Identifier: MIT
"""Moments of a surface of triangles, exact up to degree 4, and products of them that show handedness."""

from __future__ import annotations

from itertools import combinations_with_replacement, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shapegoogle_core.mesh.measures import cross_products
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = [
    "FULL",
    "SurfaceMoments",
    "full",
    "full_cubic",
    "octants",
    "principal_axes",
    "surface_moments",
    "upper",
    "upper_cubic",
    "volume",
]

FULL = [0, 1, 2, 1, 3, 4, 2, 4, 5]
"""Places in an upper triangle of the entries of its matrix, row by row."""

_CUBIC: list[tuple[int, ...]] = list(combinations_with_replacement(range(3), 3))
_FULL_CUBIC = [_CUBIC.index(tuple(sorted(place))) for place in product(range(3), repeat=3)]
# Triangles that are integrated at once.
_AT_ONCE = 1 << 11
# Third moments below this vanish but for rounding, so that they have no direction.
_LEAST_THIRD = 1e-3
# Least difference of two eigenvalues whose eigenvectors are certain, relative to the largest one.
_LEAST_GAP = 1e-3


class SurfaceMoments(NamedTuple):
    """Moments of a surface about the origin, as in `MeshMeasures`."""

    second: FloatArray
    cubic: FloatArray
    twist: FloatArray
    swirl: FloatArray
    fourth: float
    support: float


def surface_moments(
    points: FloatArray, faces: NDArray[np.integer], normals: FloatArray, weights: FloatArray
) -> SurfaceMoments:
    """Integrate polynomials over triangles, exactly up to degree 4.

    Parameters
    ----------
    points : (3, n) array
        Coordinates of the vertices.
    faces : (m, 3) array of int
        For a point cloud (m, 1).
    normals : (m, 3) array
        Of unit length; of a point cloud zeros.
    weights : (m,) array
        Together 1.

    Returns
    -------
    moments : SurfaceMoments
    """
    nodes, shares = (np.ones((1, 1)), np.ones(1)) if faces.shape[1] == 1 else _QUADRATURE
    second, cubic, swirl = np.zeros(6), np.zeros((6, 3)), np.zeros((6, 3))
    twist = np.zeros((3, 3))
    fourth = support = 0.0
    # Blocks of triangles stay in the processor's cache.
    for start in range(0, len(weights), _AT_ONCE):
        block = slice(start, start + _AT_ONCE)
        corners, facing, weight = points.take(faces[block].T, axis=1), normals[block].T, weights[block]
        # All nodes of all triangles of the block, and their weights.
        x, y, z = inside = (nodes @ corners).reshape(3, -1)
        weighted = (shares[:, None] * weight).ravel()
        products = np.stack([x * x, x * y, x * z, y * y, y * z, z * z])
        squares = products[0] + products[3] + products[5]
        cubic += products @ (weighted * inside).T
        fourth += float(weighted @ squares**2)
        # x · n is the same all over a triangle, and x × n linear.
        middle = corners.mean(axis=1)
        height = (middle * facing).sum(axis=0)
        means = shares @ products.reshape(6, len(shares), -1)
        second += means @ weight
        swirl += means @ (weight * height * facing).T
        twist += (weight * cross_products(middle.T, facing.T)) @ facing.T
        support += float(weight @ height**2)
    # (x · n) x (x × n)ᵀ, from (x · n) x xᵀ nᵀ
    turned = np.einsum("ikl,jkl->ij", swirl[FULL].reshape(3, 3, 3), _CROSS)
    return SurfaceMoments(
        second,
        np.array([cubic[FULL[3 * one + two], three] for one, two, three in _CUBIC]),
        upper((twist + twist.T) / 2),
        upper((turned + turned.T) / 2),
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
# Sign of a product of coordinates k and l in component j of a cross product.
_CROSS = np.zeros((3, 3, 3))
for _j in range(3):
    _CROSS[_j, (_j + 1) % 3, (_j + 2) % 3], _CROSS[_j, (_j + 2) % 3, (_j + 1) % 3] = 1, -1


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
    found = principal_axes(second)
    if found is None:
        return 0.0, 1.0
    gap, axes = found
    x, y, z = axes.T * np.sign(np.linalg.det(axes))
    mean = float(np.einsum("ijk,i,j,k", full_cubic(cubic), x, y, z))
    return mean, float(1 + 3 * np.abs(cubic).max() / gap)


def principal_axes(matrix: FloatArray) -> tuple[float, FloatArray] | None:
    """Find the eigenvectors of a symmetric matrix, if they can be told apart.

    Parameters
    ----------
    matrix : (3, 3) array

    Returns
    -------
    gap, axes : float, (3, 3) array
        Least difference of two eigenvalues, and the eigenvectors as columns, in ascending order. None where
        two eigenvalues are hard to tell apart, also where all are 0, as of the normals of a point cloud.
    """
    values, axes = np.linalg.eigh(matrix)
    gap = float(np.diff(values).min())
    return None if gap <= _LEAST_GAP * values[-1] else (gap, np.asarray(axes))


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
