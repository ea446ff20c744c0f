# SPDX-License-Identifier: MIT
"""Measures of a mesh that augmentations depend on: its size and its edge lengths."""

from __future__ import annotations

import numpy as np

from shapegoogle_core.mesh import Mesh, unique_edges
from shapegoogle_core.mesh.mesh import FloatArray

__all__ = ["diagonal_of", "edge_lengths"]


def diagonal_of(mesh: Mesh) -> float:
    """Return the length of the diagonal of the bounding box of the faces.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    length : float
    """
    return float(np.linalg.norm(np.ptp(mesh.vertices[np.unique(mesh.faces)], axis=0)))


def edge_lengths(mesh: Mesh) -> FloatArray:
    """Return the length of each edge, in the order of `unique_edges`.

    Parameters
    ----------
    mesh : Mesh

    Returns
    -------
    lengths : (e,) array
    """
    edges, _ = unique_edges(mesh)
    lengths: FloatArray = np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
    return lengths
