# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert Blender objects to core meshes and back."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..reading.entries import MOST_FACES
from ..reading.instancers import InstanceCollector, is_carrier
from ..reading.records import SHAPE_TYPES
from ..translation import marked, tr
from . import mesh_arrays
from .selection import collection_for_new, joined_name, mesh_objects, meshes_of, query_objects

if TYPE_CHECKING:
    from shapegoogle_core import Mesh

EMPTY = marked("{name!r} has neither faces nor single points; select a mesh or a point cloud")

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

__all__ = [
    "base_mesh",
    "evaluated_arrays",
    "evaluated_mesh",
    "new_object",
    "object_mesh",
    "placed_mesh",
    "query_meshes",
    "selected_part",
]


def base_mesh(item: Any) -> Mesh:
    """Mesh of an object before its modifiers, at world scale: vertex i is vertex i of ``item.data``.

    Parameters
    ----------
    item : bpy.types.Object
        A mesh object; in edit mode as it is edited.

    Returns
    -------
    mesh : Mesh
        Named after the object; polygons cut into triangles.

    Raises
    ------
    MeshError
        If a coordinate is not finite.
    """
    if item.mode == "EDIT":
        item.update_from_editmode()
    return _core_mesh(item.name, [(*_arrays(item.data), _matrix(item))])


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
    return placed_mesh(item.name, *_placed(item, depsgraph or bpy.context.evaluated_depsgraph_get()))


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
    return _core_mesh(name, [(vertices, faces, matrix)])


def selected_part(items: Sequence[Any]) -> Mesh:
    """Return the selected faces of all objects in edit mode, joined, at world scale.

    Parameters
    ----------
    items : sequence of bpy.types.Object
        At least one mesh object in edit mode; named after the first one with selected faces.

    Returns
    -------
    mesh : Mesh
        Before modifiers. Without faces if none are selected.
    """
    parts, names = [], []
    for item in items:
        item.update_from_editmode()
        data = item.data
        vertices, faces = _arrays(data)
        chosen = mesh_arrays.read(data.polygons, "select", 1, bool)[:, 0]
        polygon = mesh_arrays.read(data.loop_triangles, "polygon_index", 1, np.int32)[:, 0]
        faces = faces[chosen[polygon]]
        if len(faces):
            used, corners = np.unique(faces, return_inverse=True)
            parts.append((vertices[used], corners.reshape(-1, 3).astype(np.int32), _matrix(item)))
            names.append(item.name)
    name = tr("{name}, selected part").format(name=joined_name(names or [items[0].name]))
    return _core_mesh(name, parts)


def query_meshes(context: Any, *, separate: bool = False) -> list[Mesh]:
    """Return the query: the selected faces in edit mode, else the selected objects.

    Parameters
    ----------
    context : bpy.types.Context
    separate : bool, optional
        Whether several objects are shapes of their own; else they are joined. What is selected in edit mode
        is always one shape.

    Returns
    -------
    meshes : list of Mesh
        At least one. As seen, with modifiers; in edit mode before them. The active object's first.

    Raises
    ------
    MeshError
        If nothing usable is selected.
    """
    from shapegoogle_core import MeshError

    active = context.active_object
    if active is not None and active.type == "MESH" and active.mode == "EDIT":
        # Objects that share a mesh are edited as one; the active one stands for them.
        edited = {item.data: item for item in (*mesh_objects(context.objects_in_mode), active)}
        part = selected_part(sorted(edited.values(), key=lambda item: (item != active, item.name)))
        if not len(part.faces):
            names = ", ".join(repr(item.name) for item in edited.values())
            if not any(len(data.polygons) for data in edited):
                raise MeshError(
                    "{names}: there are no faces to select; leave edit mode to search with all points",
                    names=names,
                )
            raise MeshError("{names}: no faces are selected; select the faces to search with", names=names)
        return [part]
    chosen = query_objects(context.selected_objects)
    if not chosen and active is not None:
        chosen = query_objects([active])
    if not chosen:
        raise MeshError("no mesh or point cloud is selected; select the shape to search with")
    if separate:
        chosen.sort(key=lambda item: item != active)
    depsgraph = context.evaluated_depsgraph_get()
    meshes = [mesh for item in _without_parts(chosen, context) for mesh in _seen(item, context, depsgraph)]
    empty = [mesh.name for mesh in meshes if not len(mesh.vertices)]
    if empty and (separate or len(empty) == len(meshes)):
        raise MeshError(EMPTY, name=empty[0])
    return meshes if separate else [_joined(meshes)]


def _without_parts(chosen: Sequence[Any], context: Any) -> list[Any]:
    """Leave out rigs and the like whose meshes are selected too: these say which parts are meant."""
    selected = set(chosen)
    return [
        item
        for item in chosen
        if item.type in SHAPE_TYPES or not selected.intersection(meshes_of(item, context))
    ]


def _seen(item: Any, context: Any, depsgraph: Any) -> list[Mesh]:
    """Mesh of an object as it is seen; of a rig, a lattice or an empty, that of its meshes joined."""
    from shapegoogle_core import MeshError

    if item.type in SHAPE_TYPES:
        own = _placed(item, depsgraph)
        # What it instances is what is seen of it, too.
        others = _instanced(item, depsgraph) if is_carrier(item) else []
        return [_core_mesh(item.name, [own, *others] if len(own[0]) else others)]
    if item.instance_type == "COLLECTION":
        parts = _instanced(item, depsgraph)
    else:
        parts = [_placed(part, depsgraph) for part in meshes_of(item, context)]
    if not parts:
        raise MeshError(
            "{name!r} has no visible mesh: it deforms none, and none is its child; select a mesh",
            name=item.name,
        )
    return [_core_mesh(item.name, parts)]


def _instanced(item: Any, depsgraph: Any) -> list[tuple[FloatArray, IntArray, FloatArray]]:
    """Arrays of all meshes that an object instances, also in nested collections, each where it is seen.

    Raises
    ------
    MeshError
        If they have too many faces.
    """
    from shapegoogle_core import MeshError

    parts: list[tuple[FloatArray, IntArray]] = []
    numbers: dict[int, int] = {}

    def read(evaluated: Any) -> int:
        pointer = evaluated.data.as_pointer()
        if pointer not in numbers:
            numbers[pointer] = len(parts)
            parts.append(_evaluated_arrays(evaluated))
        return numbers[pointer]

    collector = InstanceCollector(SHAPE_TYPES, read, lambda _item: False, item.session_uid)
    collector.collect(depsgraph)
    matrices: defaultdict[int, list[list[float]]] = defaultdict(list)
    for instance in collector.of.get(item.session_uid, []):
        if instance.mesh is not None:
            matrices[instance.mesh].append([value for row in instance.matrix for value in row])
    faces = sum(len(parts[number][1]) * len(places) for number, places in matrices.items())
    if faces > MOST_FACES:
        raise MeshError(
            "{name!r} shows {faces:,} faces, more than one query may have; select what it instances",
            name=item.name,
            faces=faces,
        )
    return [
        (*_repeated(*parts[number], np.array(places).reshape(-1, 4, 4)), np.eye(4))
        for number, places in matrices.items()
    ]


def _repeated(vertices: FloatArray, faces: IntArray, matrices: FloatArray) -> tuple[FloatArray, IntArray]:
    """Join a mesh at many places, at once: a scatter has thousands, and the window waits.

    Parameters
    ----------
    vertices : (n, 3) array
    faces : (m, 3) array
    matrices : (k, 4, 4) array

    Returns
    -------
    vertices, faces : (k·n, 3) and (k·m, 3) array
        Mirrored ones are not inside out.
    """
    placed = np.einsum("nj,kij->kni", vertices, matrices[:, :3, :3]) + matrices[:, None, :3, 3]
    offsets = len(vertices) * np.arange(len(matrices), dtype=np.int32)
    repeated = faces + offsets[:, None, None]
    mirrored = np.linalg.det(matrices[:, :3, :3]) < 0
    repeated[mirrored] = repeated[mirrored][:, :, ::-1]
    return placed.reshape(-1, 3), repeated.reshape(-1, 3)


def object_mesh(item: Any, context: Any) -> Mesh:
    """Return the mesh of an object as it is seen, with what it instances or carries, at world scale.

    Parameters
    ----------
    item : bpy.types.Object
    context : bpy.types.Context

    Returns
    -------
    mesh : Mesh

    Raises
    ------
    MeshError
        If nothing of it is seen.
    """
    from shapegoogle_core import MeshError

    (mesh,) = _seen(item, context, context.evaluated_depsgraph_get())
    if not len(mesh.vertices):
        raise MeshError(EMPTY, name=mesh.name)
    return mesh


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


def _joined(meshes: Sequence[Mesh]) -> Mesh:
    """Join surfaces, or clouds of points; objects without either, such as wires, are ignored."""
    from shapegoogle_core import MeshError

    surfaces = [mesh for mesh in meshes if not mesh.is_point_cloud]
    cloud = next((mesh for mesh in meshes if mesh.is_point_cloud and _is_cloud(mesh)), None)
    if surfaces and cloud is not None:
        raise MeshError(
            "{cloud!r} is a point cloud and {mesh!r} a mesh, which cannot be one shape; select one of them, "
            "or choose Examples",
            cloud=cloud.name,
            mesh=surfaces[0].name,
        )
    parts = [(mesh.vertices, mesh.faces, np.eye(4)) for mesh in meshes]
    return _core_mesh(joined_name([mesh.name for mesh in meshes]), parts)


def _is_cloud(mesh: Mesh) -> bool:
    from shapegoogle_core import MeshError
    from shapegoogle_core.mesh import check_cloud

    try:
        check_cloud(mesh)
    except MeshError:
        return False
    return True


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
    return _evaluated_arrays(item.evaluated_get(depsgraph))


def _evaluated_arrays(evaluated: Any) -> tuple[FloatArray, IntArray]:
    if evaluated.type == "POINTCLOUD":
        points = mesh_arrays.read(evaluated.data.points, "co", 3, np.float32).astype(np.float64)
        return points, np.empty((0, 3), np.int32)
    data = evaluated.to_mesh()
    if data is None:
        return np.empty((0, 3)), np.empty((0, 3), np.int32)
    try:
        vertices, faces = _arrays(data)
        if len(data.edges) and not len(faces):
            vertices = vertices[:0]
        return vertices, faces
    finally:
        evaluated.to_mesh_clear()


def _placed(item: Any, depsgraph: Any) -> tuple[FloatArray, IntArray, FloatArray]:
    return (*evaluated_arrays(item, depsgraph), _matrix(item.evaluated_get(depsgraph)))


def _matrix(item: Any) -> FloatArray:
    return np.array(item.matrix_world, np.float64)


def _arrays(data: Any) -> tuple[FloatArray, IntArray]:
    """Vertices (n, 3) and triangles (m, 3) of a bpy mesh, in its own space."""
    return mesh_arrays.vertex_positions(data).astype(np.float64), mesh_arrays.triangles(data)


def _core_mesh(name: str, parts: Sequence[tuple[FloatArray, IntArray, FloatArray]]) -> Mesh:
    """Join parts, each moved to its place in the world."""
    from shapegoogle_core import Mesh

    all_vertices, all_faces, count = [np.empty((0, 3))], [np.empty((0, 3), np.int32)], 0
    for vertices, faces, matrix in parts:
        if np.linalg.det(matrix[:3, :3]) < 0:
            faces = faces[:, ::-1]  # a mirrored object would come out inside out
        # Not `@`: the threads of BLAS wait for each other on a busy machine, and the window for them.
        all_vertices.append(np.einsum("nj,ij->ni", vertices, matrix[:3, :3]) + matrix[:3, 3])
        all_faces.append(faces + count)
        count += len(vertices)
    return Mesh(np.concatenate(all_vertices), np.concatenate(all_faces), name)
