# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices, corners and triangles of bpy meshes as arrays, read in the fastest way.

Blender hands out the values of an attribute as one block of memory, but reads each loop and each triangle
on its own, which takes hundreds of times as long.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["corner_vertices", "edge_vertices", "polygon_sizes", "read", "triangles", "vertex_positions"]


def read(collection: Any, name: str, width: int, dtype: Any) -> NDArray[Any]:
    """Read a property of all items of a collection of a bpy mesh.

    Parameters
    ----------
    collection : bpy.types.bpy_prop_collection
    name : str
        Of the property.
    width : int
        How many numbers it has.
    dtype : numpy type
        What Blender keeps it as, so that nothing is converted.

    Returns
    -------
    values : (n, width) array
    """
    values = np.empty((len(collection), width), dtype)
    collection.foreach_get(name, values.ravel())
    return values


def vertex_positions(data: Any) -> NDArray[np.float32]:
    """Positions of the vertices of a mesh, in its own space.

    Parameters
    ----------
    data : bpy.types.Mesh
        After `update_from_editmode`, if it is edited.

    Returns
    -------
    positions : (n, 3) array of float32
    """
    block = _block(data, "position", len(data.vertices))
    return read(data.vertices, "co", 3, np.float32) if block is None else read(block, "vector", 3, np.float32)


def corner_vertices(data: Any) -> NDArray[np.int32]:
    """Vertex of each corner of the polygons of a mesh, polygon by polygon.

    Parameters
    ----------
    data : bpy.types.Mesh
        After `update_from_editmode`, if it is edited.

    Returns
    -------
    vertices : (c,) array of int32
    """
    return _vertices(data, ".corner_vert", data.loops, "vertex_index", 1)[:, 0]


def edge_vertices(data: Any) -> NDArray[np.int32]:
    """Vertices at both ends of each edge of a mesh.

    Parameters
    ----------
    data : bpy.types.Mesh
        After `update_from_editmode`, if it is edited.

    Returns
    -------
    vertices : (e, 2) array of int32
    """
    return _vertices(data, ".edge_verts", data.edges, "vertices", 2)


def polygon_sizes(data: Any) -> NDArray[np.int32]:
    """Corners of each polygon of a mesh, counted.

    Parameters
    ----------
    data : bpy.types.Mesh
        After `update_from_editmode`, if it is edited.

    Returns
    -------
    sizes : (m,) array of int32
    """
    if _are_triangles(data):
        return np.full(len(data.polygons), 3, np.int32)
    return read(data.polygons, "loop_total", 1, np.int32)[:, 0]


def triangles(data: Any) -> NDArray[np.int32]:
    """Triangles that Blender draws the polygons of a mesh as.

    Parameters
    ----------
    data : bpy.types.Mesh
        After `update_from_editmode`, if it is edited.

    Returns
    -------
    faces : (m, 3) array of int32
        Indices of vertices, in the order of `loop_triangles`, which can be read afterwards.
    """
    data.calc_loop_triangles()
    if _are_triangles(data):
        return corner_vertices(data).reshape(-1, 3)
    return read(data.loop_triangles, "vertices", 3, np.int32)


def _are_triangles(data: Any) -> bool:
    return len(data.loops) == 3 * len(data.polygons)  # each has at least three corners


def _vertices(data: Any, attribute: str, items: Any, name: str, width: int) -> NDArray[np.int32]:
    block = _block(data, attribute, len(items))
    return read(items, name, width, np.int32) if block is None else read(block, "value", width, np.int32)


def _block(data: Any, name: str, count: int) -> Any | None:
    """Values of an attribute; None where Blender has none, as while a mesh is edited."""
    attribute = data.attributes.get(name)
    return attribute.data if attribute is not None and len(attribute.data) == count else None
