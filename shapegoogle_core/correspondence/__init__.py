# SPDX-License-Identifier: MIT
"""Correspondence: maps between the points of a shape and those of the same shape re-posed or re-meshed."""

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
