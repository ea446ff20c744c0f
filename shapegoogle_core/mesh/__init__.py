# SPDX-License-Identifier: MIT
"""Meshes: the value, reading files, repair, resampling."""

from shapegoogle_core.mesh.holes import close_holes
from shapegoogle_core.mesh.mending import Mending, mend
from shapegoogle_core.mesh.mesh import Mesh, face_areas, unique_edges
from shapegoogle_core.mesh.reading import MESH_SUFFIXES, read_mesh
from shapegoogle_core.mesh.repair import check_surface, repair
from shapegoogle_core.mesh.resampling import resample
from shapegoogle_core.mesh.smoothing import smooth

__all__ = [
    "MESH_SUFFIXES",
    "Mending",
    "Mesh",
    "check_surface",
    "close_holes",
    "face_areas",
    "mend",
    "read_mesh",
    "repair",
    "resample",
    "smooth",
    "unique_edges",
]
