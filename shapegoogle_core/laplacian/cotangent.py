# SPDX-License-Identifier: MIT
"""Cotangent weights with lumped or mixed Voronoi areas (paper, equations 7 to 9)."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse

from shapegoogle_core.laplacian.operator import Operator
from shapegoogle_core.mesh.measures import face_areas, vertex_areas
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["corner_cotangents", "cotangent", "cotangent_voronoi", "voronoi_areas"]

# Least height of a face, as a share of its longest side: the cotangents of a lower one would swamp those of
# its neighbours. A share, so that it holds in any unit.
LEAST_HEIGHT = 1e-6


def corner_cotangents(mesh: Mesh) -> FloatArray:
    """Cotangent of the angle at each corner of each face.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.

    Returns
    -------
    cotangents : (m, 3) array
        Bounded for slivers, see `LEAST_HEIGHT`.
    """
    corners = mesh.vertices[mesh.faces]
    sides = np.roll(corners, -1, axis=1) - corners  # side k goes from corner k to the next one
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    # All corners of a face have the same divisor, which keeps its part of the matrix positive semi-definite.
    double_areas = np.maximum(2 * face_areas(mesh), LEAST_HEIGHT * longest**2)
    # At corner k one side leaves and one arrives, which flips the sign of their product.
    products = -np.einsum("fki,fki->fk", sides, np.roll(sides, 1, axis=1))
    return np.asarray(products / np.maximum(double_areas, np.finfo(float).tiny)[:, None])


def _cotangent_stiffness(mesh: Mesh) -> sparse.csc_array:
    """Assemble W: -w_ij = -(cot α_ij + cot β_ij)/2 off the diagonal, rows sum to 0 (paper, equation 7)."""
    n = len(mesh.vertices)
    half_cotangents = 0.5 * corner_cotangents(mesh)
    # The edge opposite to each corner carries that corner's cotangent.
    start = mesh.faces[:, [1, 2, 0]].ravel()
    end = mesh.faces[:, [2, 0, 1]].ravel()
    weights = half_cotangents.ravel()
    # Summing the diagonal first saves half of the duplicate entries.
    diagonal = np.bincount(start, weights, n) + np.bincount(end, weights, n)
    vertices = np.arange(n, dtype=start.dtype)
    rows = np.concatenate([start, end, vertices])
    columns = np.concatenate([end, start, vertices])
    values = np.concatenate([-weights, -weights, diagonal])
    return sparse.csc_array(sparse.coo_array((values, (rows, columns)), shape=(n, n)))


def voronoi_areas(mesh: Mesh) -> FloatArray:
    """Mixed Voronoi areas of the vertices (Meyer et al. 2003, section 3.3).

    In a face without an obtuse angle a corner P has the part that is nearer to it than to the other corners
    Q and R: (|PR|² cot Q + |PQ|² cot R) / 8. In an obtuse face this part would reach out of the face; the
    obtuse corner then has half of the area, and the two others a quarter each.

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.

    Returns
    -------
    areas : (n,) array
        In squared mesh units; they sum to the area of the surface.

    References
    ----------
    M. Meyer, M. Desbrun, P. Schröder, A. H. Barr: Discrete Differential-Geometry Operators for Triangulated
    2-Manifolds. Visualization and Mathematics III, 2003.
    """
    cotangents = corner_cotangents(mesh)
    corners = mesh.vertices[mesh.faces]
    opposite = np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1)
    # For the side opposite each corner: twice the area that the corner's angle gives to each of the others.
    parts = (opposite**2).sum(axis=2) * cotangents
    shares = parts.sum(axis=1, keepdims=True) - parts
    obtuse = np.asarray(cotangents < 0)
    shares = np.where(obtuse.any(axis=1, keepdims=True), np.where(obtuse, 2.0, 1.0), shares)
    # Normalising by the sum gives slivers, whose cotangents are bounded, their own area too.
    total = np.maximum(shares.sum(axis=1, keepdims=True), np.finfo(float).tiny)
    areas = shares / total * face_areas(mesh)[:, None]
    return np.asarray(np.bincount(mesh.faces.ravel(), areas.ravel(), len(mesh.vertices)), np.float64)


def cotangent(mesh: Mesh) -> Operator:
    """Assemble cotangent weights with lumped areas (paper, equations 7 to 9).

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.

    Returns
    -------
    operator : Operator
        The mass of a vertex is a third of the area of its faces.
    """
    mass = sparse.csc_array(sparse.diags_array(vertex_areas(mesh)))
    return Operator(_cotangent_stiffness(mesh), mass)


def cotangent_voronoi(mesh: Mesh) -> Operator:
    """Assemble cotangent weights with mixed Voronoi areas (paper, equations 7 to 9; Meyer et al. 2003).

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.

    Returns
    -------
    operator : Operator
        The mass of a vertex is the area of the surface nearest to it, see `voronoi_areas`.
    """
    mass = sparse.csc_array(sparse.diags_array(voronoi_areas(mesh)))
    return Operator(_cotangent_stiffness(mesh), mass)
