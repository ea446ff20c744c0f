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
from shapegoogle_core.mesh.connectivity import boundary_vertices
from shapegoogle_core.mesh.mesh import Mesh

__all__ = ["LAPLACIANS", "POINT_CLOUD", "build_operator"]

POINT_CLOUD = "point-cloud"
"""The operator that needs no faces."""

LAPLACIANS: dict[str, Callable[[Mesh], Operator]] = {
    "robust": robust,
    "cotangent": cotangent,
    "cotangent-voronoi": cotangent_voronoi,
    "fem1": fem1,
    "fem2": fem2,
    "fem3": fem3,
    POINT_CLOUD: point_cloud,
}
"""Operators by name."""


def build_operator(mesh: Mesh, laplacian: str = "robust") -> Operator:
    """Assemble the Laplace–Beltrami operator named `laplacian`.

    Parameters
    ----------
    mesh : Mesh
        Every vertex must belong to a face.
    laplacian : {"robust", "cotangent", "cotangent-voronoi", "fem1", "fem2", "fem3", "point-cloud"}
        A key of `LAPLACIANS`. Only "point-cloud" needs no faces, and looks at none.

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
    if laplacian == POINT_CLOUD:
        if len(mesh.vertices) < 4:
            raise MeshError(
                f"{mesh.name!r} has only {len(mesh.vertices)} points; an operator needs at least 4"
            )
    elif mesh.is_point_cloud:
        raise MeshError(
            f"{mesh.name!r} has no faces, and the {laplacian!r} Laplacian needs them; "
            f"{POINT_CLOUD!r} does without"
        )
    elif unused := int((np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices)) == 0).sum()):
        raise MeshError(f"{mesh.name!r} has {unused} vertices that no face uses; call repair() first")
    try:
        operator = LAPLACIANS[laplacian](mesh)
    except RuntimeError as error:  # robust_laplacian's own failures
        raise MeshError(f"{mesh.name!r}: the Laplacian could not be assembled ({error})") from error
    if not (np.isfinite(operator.stiffness.data).all() and (operator.lumped_mass > 0).all()):
        raise MeshError(f"{mesh.name!r} has vertices without area; call repair() first")
    if operator.boundary is None and laplacian != POINT_CLOUD:
        operator = replace(operator, boundary=np.flatnonzero(boundary_vertices(mesh)).astype(np.int64))
    return operator
