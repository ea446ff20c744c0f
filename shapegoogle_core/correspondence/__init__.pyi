# SPDX-License-Identifier: MIT
from shapegoogle_core.correspondence.matching import ShapeMap as ShapeMap
from shapegoogle_core.correspondence.matching import SurfacePoints as SurfacePoints
from shapegoogle_core.correspondence.matching import VertexMatch as VertexMatch
from shapegoogle_core.correspondence.matching import find_map as find_map
from shapegoogle_core.correspondence.matching import match_vertices as match_vertices
from shapegoogle_core.correspondence.matching import match_with_points as match_with_points
from shapegoogle_core.correspondence.matching import vertex_match as vertex_match
from shapegoogle_core.correspondence.working_surface import SurfaceSettings as SurfaceSettings

__all__: list[str]
