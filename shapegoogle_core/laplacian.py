# SPDX-License-Identifier: MIT
"""Discrete Laplace–Beltrami operators (paper, section 3.3).

Sign convention: the operator is positive semi-definite, so its eigenvalues are ≥ 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import robust_laplacian
import scipy.sparse as sparse

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh.mesh import FloatArray, Mesh, face_areas

__all__ = ["LAPLACIANS", "Operator", "build_operator", "cotangent", "fem1", "robust"]

# A face lower than this share of its longest side counts as that high: a sliver's cotangents would
# otherwise swamp its neighbours'. Relative, so it holds in any unit.
LEAST_HEIGHT = 1e-6


@dataclass(frozen=True, eq=False)
class Operator:
    """The pair (W, A) of the generalised eigenproblem W φ = λ A φ (paper, equations 8 and 10).

    Attributes
    ----------
    stiffness : (n, n) sparse array
        W, symmetric positive semi-definite, rows sum to 0, no unit.
    mass : (n, n) sparse array
        A, symmetric positive definite, squared mesh units, sums to the area. Diagonal when lumped.
    """

    stiffness: sparse.csc_array
    mass: sparse.csc_array

    @property
    def lumped_mass(self) -> FloatArray:
        """(n,) area of each vertex: the row sums of `mass`, in squared mesh units."""
        return np.asarray(self.mass.sum(axis=1), dtype=np.float64).ravel()


def _corner_cotangents(mesh: Mesh) -> FloatArray:
    """(m, 3) cotangent of the angle at each corner."""
    corners = mesh.vertices[mesh.faces]
    sides = np.roll(corners, -1, axis=1) - corners  # side k goes from corner k to the next one
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    # One divisor for all corners of a face keeps its part of the matrix positive semi-definite.
    double_areas = np.maximum(2 * face_areas(mesh), LEAST_HEIGHT * longest**2)
    # At corner k one side leaves and one arrives, which turns the sign of their product.
    products = -np.einsum("fki,fki->fk", sides, np.roll(sides, 1, axis=1))
    cotangents: FloatArray = products / np.maximum(double_areas, np.finfo(float).tiny)[:, None]
    return cotangents


def _cotangent_stiffness(mesh: Mesh) -> sparse.csc_array:
    """W with w_ij = (cot α_ij + cot β_ij)/2 off the diagonal, negated (paper, equation 7)."""
    n = len(mesh.vertices)
    half_cotangents = 0.5 * _corner_cotangents(mesh)
    # The edge opposite to each corner carries that corner's cotangent.
    start = mesh.faces[:, [1, 2, 0]].ravel()
    end = mesh.faces[:, [2, 0, 1]].ravel()
    weights = half_cotangents.ravel()
    rows = np.concatenate([start, end, start, end])
    columns = np.concatenate([end, start, start, end])
    values = np.concatenate([-weights, -weights, weights, weights])
    return sparse.csc_array(sparse.coo_array((values, (rows, columns)), shape=(n, n)))


def cotangent(mesh: Mesh) -> Operator:
    """Cotangent weights with lumped areas (paper, equations 7 to 9).

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    operator : Operator
        The mass of a vertex is a third of the area of its faces.
    """
    n = len(mesh.vertices)
    thirds = np.repeat(face_areas(mesh) / 3, 3)
    areas = np.bincount(mesh.faces.ravel(), weights=thirds, minlength=n)
    return Operator(_cotangent_stiffness(mesh), sparse.csc_array(sparse.diags_array(areas)))


def fem1(mesh: Mesh) -> Operator:
    """Linear finite elements: cotangent stiffness with the consistent mass (paper, equations 10 and 11).

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    operator : Operator
        A face of area a adds a/6 to each of its corners and a/12 to each of its edges.
    """
    n = len(mesh.vertices)
    areas = face_areas(mesh)
    rows = np.repeat(mesh.faces, 3, axis=1).ravel()
    columns = np.tile(mesh.faces, (1, 3)).ravel()
    element = (np.ones((3, 3)) + np.eye(3)).ravel() / 12
    values = np.outer(areas, element).ravel()
    mass = sparse.csc_array(sparse.coo_array((values, (rows, columns)), shape=(n, n)))
    return Operator(_cotangent_stiffness(mesh), mass)


def robust(mesh: Mesh) -> Operator:
    """Tufted, intrinsic Delaunay Laplacian: any triangle mesh, also non-manifold (Sharp and Crane, 2020).

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    operator : Operator
        Off-diagonal weights are never negative, whatever the triangles look like.

    References
    ----------
    N. Sharp, K. Crane: A Laplacian for Nonmanifold Triangle Meshes. Computer Graphics Forum 39(5), 2020.
    """
    # The library mollifies relative to the mean edge length, so the unit of the mesh does not matter.
    stiffness, mass = robust_laplacian.mesh_laplacian(mesh.vertices, mesh.faces)
    return Operator(sparse.csc_array(stiffness), sparse.csc_array(mass))


LAPLACIANS: dict[str, Callable[[Mesh], Operator]] = {
    "robust": robust,
    "cotangent": cotangent,
    "fem1": fem1,
}


def build_operator(mesh: Mesh, laplacian: str = "robust") -> Operator:
    """Assemble the Laplace–Beltrami operator named `laplacian`.

    Parameters
    ----------
    mesh : Mesh
        Every vertex must belong to a face.
    laplacian : {"robust", "cotangent", "fem1"}
        A key of `LAPLACIANS`.

    Returns
    -------
    operator : Operator

    Raises
    ------
    ValueError
        If there is no such operator.
    MeshError
        If the mesh has no faces or a vertex without area, or if the operator cannot be assembled.
    """
    if laplacian not in LAPLACIANS:
        raise ValueError(f"laplacian must be one of {', '.join(LAPLACIANS)}, not {laplacian!r}")
    if mesh.is_point_cloud:
        raise MeshError(f"{mesh.name!r} has no faces, and the {laplacian!r} Laplacian needs them")
    unused = len(mesh.vertices) - len(np.unique(mesh.faces))
    if unused:
        raise MeshError(f"{mesh.name!r} has {unused} vertices that no face uses; call repair() first")
    try:
        operator = LAPLACIANS[laplacian](mesh)
    except RuntimeError as error:  # robust_laplacian's own failures
        raise MeshError(f"{mesh.name!r}: the Laplacian could not be assembled ({error})") from error
    if not (np.isfinite(operator.stiffness.data).all() and (operator.lumped_mass > 0).all()):
        raise MeshError(f"{mesh.name!r} has vertices without area; call repair() first")
    return operator
