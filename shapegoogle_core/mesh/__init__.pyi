# SPDX-License-Identifier: MIT
from shapegoogle_core.mesh.checks import check_cloud as check_cloud
from shapegoogle_core.mesh.checks import check_surface as check_surface
from shapegoogle_core.mesh.checks import clean_surface as clean_surface
from shapegoogle_core.mesh.connectivity import unique_edges as unique_edges
from shapegoogle_core.mesh.io.reading import MESH_SUFFIXES as MESH_SUFFIXES
from shapegoogle_core.mesh.io.reading import read_mesh as read_mesh
from shapegoogle_core.mesh.measures import face_areas as face_areas
from shapegoogle_core.mesh.mesh import Mesh as Mesh
from shapegoogle_core.mesh.mesh_like import MeshLike as MeshLike
from shapegoogle_core.mesh.mesh_like import as_mesh as as_mesh
from shapegoogle_core.mesh.mesh_like import is_mesh_like as is_mesh_like

__all__: list[str]
