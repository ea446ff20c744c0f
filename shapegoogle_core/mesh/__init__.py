# SPDX-License-Identifier: MIT
"""Triangle meshes and point clouds: the value, its checks, and reading it from files."""

from shapegoogle_core.mesh.checks import check_cloud, check_surface
from shapegoogle_core.mesh.connectivity import unique_edges
from shapegoogle_core.mesh.io.reading import MESH_SUFFIXES, read_mesh
from shapegoogle_core.mesh.measures import face_areas
from shapegoogle_core.mesh.mesh import Mesh
from shapegoogle_core.mesh.mesh_like import MeshLike, as_mesh, is_mesh_like

__all__ = [
    "MESH_SUFFIXES",
    "Mesh",
    "MeshLike",
    "as_mesh",
    "check_cloud",
    "check_surface",
    "face_areas",
    "is_mesh_like",
    "read_mesh",
    "unique_edges",
]
