# SPDX-License-Identifier: MIT
"""What all transformations look at: whether there is a surface, how large it is, how long its edges are."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh, unique_edges
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["check_surface", "diagonal_of", "edge_lengths"]


def check_surface(mesh: Mesh) -> None:
    """Make sure that there is something to transform; else raise `MeshError`."""
    if mesh.is_point_cloud:
        raise MeshError(f"{mesh.name!r} has no faces; only a surface can be transformed")
    if diagonal_of(mesh) == 0:
        raise MeshError(f"{mesh.name!r}: all vertices coincide; there is nothing to transform")


def diagonal_of(mesh: Mesh) -> float:
    """Length of the diagonal of the bounding box."""
    return float(np.linalg.norm(np.ptp(mesh.vertices[np.unique(mesh.faces)], axis=0)))


def edge_lengths(mesh: Mesh) -> FloatArray:
    """Length of each of `unique_edges`."""
    edges, _ = unique_edges(mesh)
    lengths: FloatArray = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    return lengths
