# SPDX-License-Identifier: MIT
"""Laplacians of meshes and point clouds in any state, on intrinsic triangulations (Sharp and Crane 2020)."""

from __future__ import annotations

import robust_laplacian
import scipy.sparse as sparse

from shapegoogle_core.laplacian.operator import Operator
from shapegoogle_core.mesh.mesh import Mesh

__all__ = ["point_cloud", "robust"]

# Number of neighbours for a point's tangent plane and local triangulation: the default of robust_laplacian.
NEIGHBOURS = 30


def robust(mesh: Mesh) -> Operator:
    """Assemble the tufted intrinsic Delaunay Laplacian of any triangle mesh (Sharp and Crane 2020).

    Parameters
    ----------
    mesh : Mesh
        A mesh of triangles; it need not be manifold.

    Returns
    -------
    operator : Operator
        The weights between vertices are never negative, however thin the triangles are.

    References
    ----------
    N. Sharp, K. Crane: A Laplacian for Nonmanifold Triangle Meshes. Computer Graphics Forum 39(5), 2020.
    """
    # The library mollifies relative to the mean edge length, so the unit of the mesh does not matter.
    stiffness, mass = robust_laplacian.mesh_laplacian(mesh.vertices, mesh.faces)
    return Operator(sparse.csc_array(stiffness), sparse.csc_array(mass))


def point_cloud(mesh: Mesh) -> Operator:
    """Assemble the Laplacian of points without faces (paper, section 3.3; Sharp and Crane 2020, section 5.7).

    The nearest neighbours of each point are projected to their tangent plane and triangulated (Delaunay)
    there. The triangles at all points, each of which is found up to three times, form one non-manifold mesh
    with a third of the weight; its operator is that of `robust`. The paper cites Belkin, Sun and Wang (2009),
    who also triangulate in tangent planes but integrate a heat kernel over the triangles, which gives no
    sparse matrix.

    Parameters
    ----------
    mesh : Mesh
        Its faces, if there are any, are ignored.

    Returns
    -------
    operator : Operator
        The mass of a point is its share of the area of the surface.
    """
    neighbours = min(NEIGHBOURS, len(mesh.vertices) - 1)
    stiffness, mass = robust_laplacian.point_cloud_laplacian(mesh.vertices, n_neighbors=neighbours)
    return Operator(sparse.csc_array(stiffness), sparse.csc_array(mass))
