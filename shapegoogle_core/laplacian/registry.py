# SPDX-License-Identifier: MIT
"""Laplace–Beltrami operators by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from shapegoogle_core.errors import MeshError
from shapegoogle_core.laplacian.cotangent import cotangent, cotangent_voronoi
from shapegoogle_core.laplacian.fem import fem1, fem2, fem3
from shapegoogle_core.laplacian.operator import Operator
from shapegoogle_core.laplacian.tufted import point_cloud, robust
from shapegoogle_core.mesh import MeshLike, as_mesh
from shapegoogle_core.mesh.checks import REPAIR, check_cloud, check_surface, check_used
from shapegoogle_core.mesh.connectivity import boundary_vertices
from shapegoogle_core.mesh.mesh import Mesh

__all__ = ["LAPLACIANS", "POINT_CLOUD", "build_operator"]

POINT_CLOUD = "point-cloud"
"""Name of the operator that needs no faces."""

LAPLACIANS: dict[str, Callable[[Mesh], Operator]] = {
    "robust": robust,
    "cotangent": cotangent,
    "cotangent-voronoi": cotangent_voronoi,
    "fem1": fem1,
    "fem2": fem2,
    "fem3": fem3,
    POINT_CLOUD: point_cloud,
}
"""Functions that assemble an operator, by name."""


def build_operator(mesh: MeshLike, laplacian: str = "robust") -> Operator:
    """Assemble a discrete Laplace–Beltrami operator (paper, section 3.3).

    Parameters
    ----------
    mesh : MeshLike
        A mesh in which every vertex belongs to a face, or points for "point-cloud".
    laplacian : {"robust", "cotangent", "cotangent-voronoi", "fem1", "fem2", "fem3", "point-cloud"}
        "robust": tufted intrinsic Delaunay (Sharp and Crane 2020), for meshes in any state. "cotangent":
        cotangent weights and lumped areas (equations 7 to 9). "cotangent-voronoi": the same with mixed
        Voronoi areas. "fem1", "fem2", "fem3": linear, quadratic and cubic finite elements (equations 10 and
        11). "point-cloud": needs no faces and ignores those there are.

    Returns
    -------
    operator : Operator
        Stiffness W and mass A of W φ = λ A φ.

    Raises
    ------
    ValueError
        If there is no operator of that name.
    MeshError
        If the mesh has no faces or a vertex without area, or if the operator cannot be assembled.

    See Also
    --------
    compute_spectrum : Eigenpairs of an operator.

    Examples
    --------
    >>> import shapegoogle_core as sg
    >>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> mesh = sg.Mesh(vertices, [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    >>> operator = sg.build_operator(mesh, "cotangent")
    >>> operator.stiffness.shape
    (4, 4)
    >>> bool(abs(operator.mass.sum() - mesh.area) < 1e-9)
    True
    """
    mesh = as_mesh(mesh)
    if laplacian not in LAPLACIANS:
        raise ValueError(f"laplacian must be one of {', '.join(LAPLACIANS)}, not {laplacian!r}")
    if laplacian == POINT_CLOUD:
        if len(mesh.vertices) < 4:
            raise MeshError(
                f"{mesh.name!r} has only {len(mesh.vertices)} points; an operator needs at least 4"
            )
    elif mesh.is_point_cloud:
        raise MeshError(
            f"{mesh.name!r} has no faces, which the Laplacian {laplacian!r} needs; use {POINT_CLOUD!r}"
        )
    else:
        check_used(mesh)
    try:
        operator = LAPLACIANS[laplacian](mesh)
    except RuntimeError as error:  # from the library robust_laplacian
        (check_cloud if laplacian == POINT_CLOUD else check_surface)(mesh)  # knows the usual causes
        raise MeshError(f"{mesh.name!r}: the Laplacian could not be assembled; {REPAIR}") from error
    if not (np.isfinite(operator.stiffness.data).all() and (operator.lumped_mass > 0).all()):
        raise MeshError(f"{mesh.name!r} has vertices without area; {REPAIR}")
    if operator.boundary is None and laplacian != POINT_CLOUD:
        operator = replace(operator, boundary=np.flatnonzero(boundary_vertices(mesh)).astype(np.int64))
    return operator
