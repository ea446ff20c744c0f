# SPDX-License-Identifier: MIT
"""Which point of one shape is which point of another: maps between re-posed and re-meshed shapes."""

from shapegoogle_core.correspondence.matching import (
    ShapeMap,
    SurfacePoints,
    VertexMatch,
    find_map,
    match_vertices,
    match_with_points,
    vertex_match,
)
from shapegoogle_core.correspondence.working_surface import SurfaceSettings

__all__ = [
    "ShapeMap",
    "SurfacePoints",
    "SurfaceSettings",
    "VertexMatch",
    "find_map",
    "match_vertices",
    "match_with_points",
    "vertex_match",
]
