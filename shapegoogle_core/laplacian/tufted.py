# SPDX-License-Identifier: MIT
"""Operators on an intrinsic triangulation, for meshes and points in any state (Sharp and Crane 2020)."""

from __future__ import annotations

import robust_laplacian
import scipy.sparse as sparse

from shapegoogle_core.laplacian.operator import Operator
from shapegoogle_core.mesh.mesh import Mesh

__all__ = ["point_cloud", "robust"]

# Of a point's tangent plane and local triangulation; the library's own choice.
NEIGHBOURS = 30


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


def point_cloud(mesh: Mesh) -> Operator:
    """Laplacian of points without faces (paper, section 3.3; Sharp and Crane 2020, section 5.7).

    Around every point its nearest neighbours are projected to their tangent plane and triangulated (Delaunay)
    there. The triangles at all points, each of which is found up to three times, are one non-manifold mesh
    with a third of the weight; its operator is `robust`'s. The paper names Belkin, Sun and Wang (2009), who
    also triangulate in tangent planes but integrate a heat kernel over them, which makes no sparse matrix.

    Parameters
    ----------
    mesh : Mesh
        Faces, if there are any, are not looked at.

    Returns
    -------
    operator : Operator
        The mass of a point is its share of the area of the surface it stands on.
    """
    neighbours = min(NEIGHBOURS, len(mesh.vertices) - 1)
    stiffness, mass = robust_laplacian.point_cloud_laplacian(mesh.vertices, n_neighbors=neighbours)
    return Operator(sparse.csc_array(stiffness), sparse.csc_array(mass))
