# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert Blender objects to core meshes and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from numpy.typing import NDArray

from . import mesh_arrays
from .selection import collection_for_new

if TYPE_CHECKING:
    from shapegoogle_core import Mesh

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

__all__ = [
    "FloatArray",
    "IntArray",
    "arrays_of_evaluated",
    "base_arrays",
    "base_mesh",
    "core_mesh",
    "evaluated_arrays",
    "evaluated_mesh",
    "matrix_of",
    "new_object",
    "placed_arrays",
    "placed_mesh",
]


def base_mesh(item: Any, name: str = "") -> Mesh:
    """Mesh of an object before its modifiers, at world scale: vertex i is vertex i of ``item.data``.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object; in edit mode as it is edited.
    name : str, optional
        Of the mesh in messages; that of the object when left out.

    Returns
    -------
    mesh : Mesh
        Polygons cut into triangles.

    Raises
    ------
    MeshError
        If a coordinate is not finite.
    """
    if item.mode == "EDIT":
        item.update_from_editmode()
    return core_mesh(name or item.name, [(*base_arrays(item.data), matrix_of(item))])


def evaluated_mesh(item: Any, depsgraph: Any | None = None) -> Mesh:
    """Mesh of an object as it is seen: with modifiers, at world scale.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh or a point cloud.
    depsgraph : bpy.types.Depsgraph, optional
        That of the context when left out.

    Returns
    -------
    mesh : Mesh
        Without faces if there are points alone. Wires, edges without any face, have no points either: those
        are not spread over a surface.

    Raises
    ------
    MeshError
        If a coordinate is not finite.
    """
    return placed_mesh(item.name, *placed_arrays(item, depsgraph or bpy.context.evaluated_depsgraph_get()))


def placed_mesh(name: str, vertices: FloatArray, faces: IntArray, matrix: FloatArray) -> Mesh:
    """Mesh of an object in the world.

    Parameters
    ----------
    name : str
    vertices, faces : (n, 3) and (m, 3) array
        In the object's own space.
    matrix : (4, 4) array
        The object's, to the world.

    Returns
    -------
    mesh : Mesh

    Raises
    ------
    MeshError
        If a coordinate is not finite.
    """
    return core_mesh(name, [(vertices, faces, matrix)])


def new_object(context: Any, mesh: Mesh, name: str) -> Any:
    """Make an object of a core mesh in the active collection.

    Parameters
    ----------
    context : bpy.types.Context
    mesh : Mesh
    name : str

    Returns
    -------
    item : bpy.types.Object
    """
    data = bpy.data.meshes.new(name)
    data.from_pydata(mesh.vertices.tolist(), [], mesh.faces.tolist())
    item = bpy.data.objects.new(name, data)
    collection_for_new(context).objects.link(item)
    return item


def evaluated_arrays(item: Any, depsgraph: Any) -> tuple[FloatArray, IntArray]:
    """Vertices and triangles of an object as it is seen, in its own space.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh or a point cloud.
    depsgraph : bpy.types.Depsgraph

    Returns
    -------
    vertices, faces : (n, 3) array of float64, (m, 3) array of int32
        Of a wire, edges without any face, no vertices either.
    """
    return arrays_of_evaluated(item.evaluated_get(depsgraph))


def arrays_of_evaluated(evaluated: Any) -> tuple[FloatArray, IntArray]:
    """Vertices and triangles of an evaluated object, as `evaluated_arrays` gives them.

    Parameters
    ----------
    evaluated : bpy.types.Object

    Returns
    -------
    vertices, faces : (n, 3) array of float64, (m, 3) array of int32
    """
    if evaluated.type == "POINTCLOUD":
        points = mesh_arrays.read(evaluated.data.points, "co", 3, np.float32).astype(np.float64)
        return points, np.empty((0, 3), np.int32)
    data = evaluated.to_mesh()
    if data is None:
        return np.empty((0, 3)), np.empty((0, 3), np.int32)
    try:
        vertices, faces = base_arrays(data)
        if len(data.edges) and not len(faces):
            vertices = vertices[:0]
        return vertices, faces
    finally:
        evaluated.to_mesh_clear()


def placed_arrays(item: Any, depsgraph: Any) -> tuple[FloatArray, IntArray, FloatArray]:
    """Vertices and triangles of an object as it is seen, and its place.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh or a point cloud.
    depsgraph : bpy.types.Depsgraph

    Returns
    -------
    vertices, faces : (n, 3) array of float64, (m, 3) array of int32
        In its own space.
    matrix : (4, 4) array
        From there to the world.
    """
    return (*evaluated_arrays(item, depsgraph), matrix_of(item.evaluated_get(depsgraph)))


def matrix_of(item: Any) -> FloatArray:
    """Matrix of an object, to the world.

    Parameters
    ----------
    item : bpy.types.Object

    Returns
    -------
    matrix : (4, 4) array
    """
    return np.array(item.matrix_world, np.float64)


def base_arrays(data: Any) -> tuple[FloatArray, IntArray]:
    """Vertices and triangles of a bpy mesh.

    Parameters
    ----------
    data : bpy.types.Mesh

    Returns
    -------
    vertices, faces : (n, 3) array of float64, (m, 3) array of int32
        In its own space.
    """
    return mesh_arrays.vertex_positions(data).astype(np.float64), mesh_arrays.triangles(data)


def core_mesh(name: str, parts: Sequence[tuple[FloatArray, IntArray, FloatArray | None]]) -> Mesh:
    """Join parts, each moved to its place in the world.

    Parameters
    ----------
    name : str
    parts : sequence of (vertices, faces, matrix)
        Without a matrix: in the world already.

    Returns
    -------
    mesh : Mesh

    Raises
    ------
    MeshError
        If a coordinate is not finite.
    """
    from shapegoogle_core import Mesh

    all_vertices, all_faces, count = [np.empty((0, 3))], [np.empty((0, 3), np.int32)], 0
    for vertices, faces, matrix in parts:
        if matrix is None:
            all_vertices.append(vertices)
        else:
            if np.linalg.det(matrix[:3, :3]) < 0:
                faces = faces[:, ::-1]  # a mirrored object would come out inside out
            # Not `@`: the threads of BLAS wait for each other on a busy machine, and the window for them.
            all_vertices.append(np.einsum("nj,ij->ni", vertices, matrix[:3, :3]) + matrix[:3, 3])
        all_faces.append(faces + count)
        count += len(vertices)
    return Mesh(np.concatenate(all_vertices), np.concatenate(all_faces), name)
