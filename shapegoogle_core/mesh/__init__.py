# SPDX-License-Identifier: MIT
"""Meshes: the value, reading files, repair, resampling."""

from shapegoogle_core.mesh.mesh import Mesh, face_areas, unique_edges
from shapegoogle_core.mesh.reading import MESH_SUFFIXES, read_mesh
from shapegoogle_core.mesh.repair import check_surface, repair

__all__ = [
    "MESH_SUFFIXES",
    "Mesh",
    "check_surface",
    "face_areas",
    "read_mesh",
    "repair",
    "unique_edges",
]
