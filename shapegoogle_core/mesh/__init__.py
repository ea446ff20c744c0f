# SPDX-License-Identifier: MIT
"""Meshes: the value, reading files, repair, resampling."""

from shapegoogle_core.mesh.mesh import Mesh, face_areas, unique_edges
from shapegoogle_core.mesh.repair import check_surface, repair

__all__ = ["Mesh", "check_surface", "face_areas", "repair", "unique_edges"]
