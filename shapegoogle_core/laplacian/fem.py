# SPDX-License-Identifier: MIT
"""Finite elements: piecewise polynomials on the flat triangles of a mesh (paper, section 3.3).

A polynomial of degree p on a triangle is determined by its values at (p + 1)(p + 2)/2 nodes with barycentric
coordinates α/p, where α = (α₁, α₂, α₃) are whole numbers that sum to p: the corners, p - 1 nodes on each side
and, for cubic polynomials, the centre.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product
from math import factorial

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from shapegoogle_core.laplacian.cotangent import corner_cotangents
from shapegoogle_core.laplacian.operator import Operator
from shapegoogle_core.mesh.connectivity import unique_edges
from shapegoogle_core.mesh.measures import face_areas, vertex_areas
from shapegoogle_core.mesh.mesh import FloatArray, Mesh

__all__ = ["fem1", "fem2", "fem3"]


def fem1(mesh: Mesh) -> Operator:
    """Assemble linear finite elements: cotangent weights, consistent mass (paper, equations 10 and 11).

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.

    Returns
    -------
    operator : Operator
        A face of area a adds a/6 to the mass of each of its corners and a/12 to that of each of its edges.
    """
    return _lagrange(mesh, 1)


def fem2(mesh: Mesh) -> Operator:
    """Assemble quadratic finite elements with the consistent mass (paper, equations 10 and 11).

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.

    Returns
    -------
    operator : Operator
        One degree of freedom at each vertex and one at the middle of each edge.

    Notes
    -----
    Eigenvalues of a flat domain have an error of order h⁴, where h is the edge length. On a curved surface
    the flat triangles themselves have an error of order h², whatever the elements.
    """
    return _lagrange(mesh, 2)


def fem3(mesh: Mesh) -> Operator:
    """Assemble cubic finite elements with the consistent mass (paper, equations 10 and 11).

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles.

    Returns
    -------
    operator : Operator
        One degree of freedom at each vertex, two on each edge and one at the centre of each face.

    Notes
    -----
    Eigenvalues of a flat domain have an error of order h⁶; those of a curved surface, as for `fem2`, of h².
    """
    return _lagrange(mesh, 3)


@dataclass(frozen=True, eq=False)
class _Element:
    """Nodes of a triangle, and integrals of its b basis functions as multiples of its area.

    Attributes
    ----------
    nodes : (b, 3) array of int
        α; the corners first.
    mass : (b, b) array
        Means of φ_i φ_j.
    stiffness : (3, b, b) array
        For each corner c, with a and b the two others: means of (∂_a - ∂_b) φ_i (∂_a - ∂_b) φ_j.
    """

    nodes: NDArray[np.int64]
    mass: FloatArray
    stiffness: FloatArray


@cache
def _element(degree: int) -> _Element:
    """Integrate the Lagrange basis exactly, as polynomials in barycentric coordinates."""
    nodes = _exponents(degree)
    # φ_i = Σ_α C_iα λ^α with φ_i = 1 at node i and 0 at the others.
    monomials_at_nodes = (nodes[:, None, :] / degree) ** nodes[None, :, :]
    coefficients = np.linalg.inv(monomials_at_nodes.prod(axis=2)).T
    mass = coefficients @ _means(nodes, nodes) @ coefficients.T
    lower = _exponents(degree - 1)
    means = _means(lower, lower)
    stiffness = np.empty((3, len(nodes), len(nodes)))
    for corner in range(3):
        a, b = (corner + 1) % 3, (corner + 2) % 3
        slopes = coefficients @ (_derivative(nodes, lower, a) - _derivative(nodes, lower, b))
        stiffness[corner] = slopes @ means @ slopes.T
    return _Element(nodes, mass, stiffness)


def _exponents(degree: int) -> NDArray[np.int64]:
    """List all α of whole numbers ≥ 0 that sum to the degree, the corners first and in their order."""
    every = [alpha for alpha in product(range(degree + 1), repeat=3) if sum(alpha) == degree]
    every.sort(key=lambda alpha: (max(alpha) < degree, tuple(-entry for entry in alpha)))
    return np.array(every)


def _means(one: NDArray[np.int64], other: NDArray[np.int64]) -> FloatArray:
    """Mean of λ^(α + β) over a triangle: 2 α! / (|α| + 2)! for each exponent."""
    mean = np.vectorize(
        lambda i, j, k: 2 * factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 2),
        otypes=[np.float64],
    )
    together = one[:, None] + other[None]
    return np.asarray(mean(together[..., 0], together[..., 1], together[..., 2]))


def _derivative(nodes: NDArray[np.int64], lower: NDArray[np.int64], axis: int) -> FloatArray:
    """∂λ^α/∂λ_axis = α_axis λ^(α - e_axis), as a matrix from monomials to those of one degree less."""
    reduced = nodes - np.eye(3, dtype=np.int64)[axis]
    return np.asarray((reduced[:, None] == lower[None]).all(axis=2) * nodes[:, axis, None], np.float64)


def _lagrange(mesh: Mesh, degree: int) -> Operator:
    """Assemble W_ij = ∫ ∇φ_i · ∇φ_j and A_ij = ∫ φ_i φ_j for piecewise polynomials of a degree.

    In a face of area T, ∇λ_a · ∇λ_b T = -cot(γ)/2 where γ is the angle at the third corner. As the λ sum to
    1, the integral of ∇φ_i · ∇φ_j is Σ_c cot(γ_c)/2 times the mean of (∂_a - ∂_b) φ_i (∂_a - ∂_b) φ_j: the
    cotangent weights, for any degree.
    """
    element = _element(degree)
    freedoms, count, boundary = _number(mesh, element.nodes)
    stiffness = np.einsum("fc,cij->fij", 0.5 * corner_cotangents(mesh), element.stiffness)
    mass = face_areas(mesh)[:, None, None] * element.mass
    rows = np.repeat(freedoms, len(element.nodes), axis=1).ravel()
    columns = np.tile(freedoms, (1, len(element.nodes))).ravel()

    def assembled(values: FloatArray) -> sparse.csc_array:
        return sparse.csc_array(sparse.coo_array((values.ravel(), (rows, columns)), shape=(count, count)))

    return Operator(assembled(stiffness), assembled(mass), vertex_areas(mesh), boundary)


def _number(mesh: Mesh, nodes: NDArray[np.int64]) -> tuple[NDArray[np.int64], int, NDArray[np.int64]]:
    """Give numbers to the nodes of all faces: at vertices first, then on edges, then inside.

    Returns
    -------
    freedoms : (m, b) array of int
        Number of each node of each face. The faces at an edge share its nodes.
    count : int
        d, the number of nodes.
    boundary : (·,) array of int
        Nodes on the open boundary.
    """
    n, degree = len(mesh.vertices), int(nodes.sum(axis=1)[0])
    edges, face_counts = unique_edges(mesh)
    keys = edges[:, 0].astype(np.int64) * n + edges[:, 1]
    faces = mesh.faces.astype(np.int64)
    columns: list[NDArray[np.int64]] = []
    inside = 0
    for alpha in nodes:
        (corners,) = np.nonzero(alpha)
        if len(corners) == 1:
            columns.append(faces[:, corners[0]])
        elif len(corners) == 2:
            one, other = faces[:, corners].T
            edge = np.searchsorted(keys, np.minimum(one, other) * n + np.maximum(one, other))
            # Nodes are counted from the vertex of smaller index, whichever way a face runs along the edge.
            step = np.where(one < other, alpha[corners[1]], alpha[corners[0]])
            columns.append(n + edge * (degree - 1) + step - 1)
        else:
            columns.append(n + len(edges) * (degree - 1) + inside * len(faces) + np.arange(len(faces)))
            inside += 1
    on_edges = n + np.flatnonzero(face_counts == 1)[:, None] * (degree - 1) + np.arange(degree - 1)
    boundary = np.concatenate([np.unique(edges[face_counts == 1]), on_edges.ravel()]).astype(np.int64)
    return np.stack(columns, axis=1), n + len(edges) * (degree - 1) + inside * len(faces), boundary
