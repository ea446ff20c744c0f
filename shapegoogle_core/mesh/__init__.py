# SPDX-License-Identifier: MIT
"""Meshes: the value, reading files, repair, resampling."""

from shapegoogle_core.mesh.mesh import Mesh, face_areas, unique_edges

__all__ = ["Mesh", "face_areas", "unique_edges"]
