# SPDX-License-Identifier: MIT
"""Meshes: the value, reading files, repair, resampling."""

from shapegoogle_core.mesh.cloud import check_cloud
from shapegoogle_core.mesh.holes import close_holes
from shapegoogle_core.mesh.mesh import Mesh, face_areas, unique_edges
from shapegoogle_core.mesh.reading import MESH_SUFFIXES, read_mesh
from shapegoogle_core.mesh.repair import check_surface, repair, repair_mapped
from shapegoogle_core.mesh.resampling import resample

__all__ = [
    "MESH_SUFFIXES",
    "Mesh",
    "check_cloud",
    "check_surface",
    "close_holes",
    "face_areas",
    "read_mesh",
    "repair",
    "repair_mapped",
    "resample",
    "unique_edges",
]
