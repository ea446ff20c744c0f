# SPDX-License-Identifier: GPL-3.0-or-later
"""The shapes that an artist searches with: what is selected, read in short steps.

A scatter may have tens of thousands of instances, and a selection thousands of objects, while the window
waits; see `..time_slices`.
"""

from __future__ import annotations

import hashlib
import time
from collections import defaultdict
from collections.abc import Generator, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..reading.entries import MOST_FACES
from ..reading.instancers import MOST_INSTANCES, InstanceCollector, is_carrier
from ..reading.records import SHAPE_TYPES
from ..time_slices import result_of
from ..translation import marked, tr
from . import mesh_arrays
from .meshes import (
    FloatArray,
    IntArray,
    arrays_of_evaluated,
    base_arrays,
    core_mesh,
    matrix_of,
    placed_arrays,
)
from .selection import joined_name, mesh_objects, meshes_of, query_objects

if TYPE_CHECKING:
    from shapegoogle_core import Mesh

__all__ = ["object_mesh", "object_steps", "query_meshes", "query_steps", "selected_part"]

T = TypeVar("T")
Part = tuple[FloatArray, IntArray, FloatArray | None]

EMPTY = marked("{name!r} has neither faces nor single points; select a mesh or a point cloud")

# How long instances are listed at a stretch: to go on where one has stopped takes time, too.
SECONDS_OF_LISTING = 0.1
# Instances from one step to the next, and faces that are placed in one step.
INSTANCES_OF_STEP = 200
FACES_OF_STEP = 30_000


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
        vertices, faces = base_arrays(data)
        chosen = mesh_arrays.read(data.polygons, "select", 1, bool)[:, 0]
        polygon = mesh_arrays.read(data.loop_triangles, "polygon_index", 1, np.int32)[:, 0]
        faces = faces[chosen[polygon]]
        if len(faces):
            used, corners = np.unique(faces, return_inverse=True)
            parts.append((vertices[used], corners.reshape(-1, 3).astype(np.int32), matrix_of(item)))
            names.append(item.name)
    name = tr("{name}, selected part").format(name=joined_name(names or [items[0].name]))
    return core_mesh(name, parts)


def query_meshes(context: Any, *, separate: bool = False, notes: list[str] | None = None) -> list[Mesh]:
    """Return the query at a stretch; see `query_steps`."""
    return result_of(query_steps(context, separate=separate, notes=notes))


def query_steps(
    context: Any, *, separate: bool = False, notes: list[str] | None = None
) -> Generator[bool, None, list[Mesh]]:
    """Read the query, the selected faces in edit mode, else the selected objects.

    Parameters
    ----------
    context : bpy.types.Context
        Asked in the first step for what is selected.
    separate : bool, optional
        Whether several objects are shapes of their own; else they are joined. What is selected in edit mode
        is always one shape.
    notes : list of str, optional
        Gets a sentence, translated, for each object of which only a part is read.

    Yields
    ------
    alone : bool
        Whether the step took long by itself, see `..time_slices.next_slice`.

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
    meshes = []
    for item in _without_parts(chosen, context):
        meshes.append((yield from _seen(item, context, notes)))
        yield False
    yield len(meshes) > 1
    empty = [mesh.name for mesh in meshes if not len(mesh.vertices)]
    if empty and (separate or len(empty) == len(meshes)):
        raise MeshError(EMPTY, name=empty[0])
    return meshes if separate else [_joined(meshes)]


def object_mesh(item: Any, context: Any, notes: list[str] | None = None) -> Mesh:
    """Return the mesh of an object at a stretch; see `object_steps`."""
    return result_of(object_steps(item, context, notes))


def object_steps(item: Any, context: Any, notes: list[str] | None = None) -> Generator[bool, None, Mesh]:
    """Read the mesh of an object as it is seen, with what it instances or carries, at world scale.

    Parameters
    ----------
    item : bpy.types.Object
    context : bpy.types.Context
    notes : list of str, optional
        See `query_steps`.

    Yields
    ------
    alone : bool
        See `query_steps`.

    Returns
    -------
    mesh : Mesh

    Raises
    ------
    MeshError
        If nothing of it is seen.
    """
    from shapegoogle_core import MeshError

    mesh = yield from _seen(item, context, notes)
    if not len(mesh.vertices):
        raise MeshError(EMPTY, name=mesh.name)
    return mesh


def _without_parts(chosen: Sequence[Any], context: Any) -> list[Any]:
    """Leave out rigs and the like whose meshes are selected too: these say which parts are meant."""
    selected = set(chosen)
    return [
        item
        for item in chosen
        if item.type in SHAPE_TYPES or not selected.intersection(meshes_of(item, context))
    ]


def _seen(item: Any, context: Any, notes: list[str] | None) -> Generator[bool, None, Mesh]:
    """Read the mesh of an object as it is seen; of a rig, a lattice or an empty, its meshes joined."""
    from shapegoogle_core import MeshError

    parts: list[Part] = []
    if item.type in SHAPE_TYPES:
        own = placed_arrays(item, context.evaluated_depsgraph_get())
        if len(own[0]):
            parts.append(own)
        # What it instances is what is seen of it, too.
        if is_carrier(item):
            parts += yield from _instanced(item, context, notes)
    else:
        if item.instance_type == "COLLECTION":
            parts = yield from _instanced(item, context, notes)
        else:
            for part in meshes_of(item, context):
                parts.append(placed_arrays(part, context.evaluated_depsgraph_get()))
                yield False
        if not parts:
            raise MeshError(
                "{name!r} has no visible mesh: it deforms none, and none is its child; select a mesh",
                name=item.name,
            )
    # To join many parts takes as long as a slice.
    yield len(parts) > 1
    return core_mesh(item.name, parts)


def _instanced(item: Any, context: Any, notes: list[str] | None) -> Generator[bool, None, list[Part]]:
    """Read all meshes that an object instances, also in nested collections, each where it is seen.

    Raises
    ------
    MeshError
        If they have too many faces.
    """
    from shapegoogle_core import MeshError

    parts: list[tuple[FloatArray, IntArray]] = []
    known: dict[bytes, int] = {}

    def read(evaluated: Any) -> int:
        vertices, faces = arrays_of_evaluated(evaluated)
        # By content: between two slices something may be evaluated anew, and have another's address.
        digest = hashlib.blake2b(vertices.data, digest_size=16)
        digest.update(faces.data)
        number = known.setdefault(digest.digest(), len(parts))
        if number == len(parts):
            parts.append((vertices, faces))
        return number

    collector = InstanceCollector(SHAPE_TYPES, read, lambda _item: False, item.session_uid)
    while not collector.collect(context.evaluated_depsgraph_get(), _time_for(SECONDS_OF_LISTING)):
        yield True
    if collector.further and notes is not None:
        text = tr("only the first {count:,} of the {total:,} instances of {name!r} are part of the query")
        total = MOST_INSTANCES + collector.further
        notes.append(text.format(count=MOST_INSTANCES, total=total, name=item.name))
    matrices: defaultdict[int, list[list[float]]] = defaultdict(list)
    for number, instance in enumerate(collector.of.get(item.session_uid, []), 1):
        if instance.mesh is not None:
            matrices[instance.mesh].append([value for row in instance.matrix for value in row])
        if not number % INSTANCES_OF_STEP:
            yield False
    faces = sum(len(parts[number][1]) * len(places) for number, places in matrices.items())
    if faces > MOST_FACES:
        raise MeshError(
            "{name!r} shows {faces:,} faces, more than one query may have; select what it instances",
            name=item.name,
            faces=faces,
        )
    placed: list[Part] = []
    for number, places in matrices.items():
        vertices, corners = parts[number]
        for some in _portions(places, max(1, FACES_OF_STEP // max(1, len(corners)))):
            placed.append((*_repeated(vertices, corners, np.array(some).reshape(-1, 4, 4)), None))
            yield False
    return placed


def _time_for(seconds: float) -> Any:
    """Return a function that says whether there is still time."""
    end = time.monotonic() + seconds
    return lambda: time.monotonic() < end


def _portions(items: Sequence[T], size: int) -> Iterator[Sequence[T]]:
    return (items[start : start + size] for start in range(0, len(items), size))


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
    if len(meshes) == 1:
        return meshes[0]
    parts = [(mesh.vertices, mesh.faces, None) for mesh in meshes]
    return core_mesh(joined_name([mesh.name for mesh in meshes]), parts)


def _is_cloud(mesh: Mesh) -> bool:
    from shapegoogle_core import MeshError
    from shapegoogle_core.mesh import check_cloud

    try:
        check_cloud(mesh)
    except MeshError:
        return False
    return True
