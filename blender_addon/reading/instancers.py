# SPDX-License-Identifier: GPL-3.0-or-later
"""What objects instance: collections, geometry nodes, particles and vertices, as Blender shows it.

It imports nothing but Python's own modules, since `reader` runs in a Blender without this add-on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

__all__ = ["MOST_INSTANCES", "Instance", "Instances", "collect_instances", "is_carrier", "show_realized"]

MOST_INSTANCES = 50_000
"""Instances of one file that are taken into account; a lawn may have millions."""

# Blender fills the numbers of an instance up with the largest one.
_NO_NUMBER = 2**31 - 1
_REALIZE = "GeometryNodeRealizeInstances"


@dataclass(frozen=True)
class Instance:
    """A mesh that an object instances.

    Attributes
    ----------
    uid : int
        Session number of the object whose mesh it is; that of the instancing object itself for a mesh that
        its nodes make.
    mesh : int or None
        Number of a mesh that belongs to no object of the file; None for that of the object.
    matrix : mathutils.Matrix
        To the world.
    base : mathutils.Matrix
        Of the instancing object, to the world.
    group : tuple of int
        The same for all meshes that are instanced as one, such as those of a collection.
    """

    uid: int
    mesh: int | None
    matrix: Any
    base: Any
    group: tuple[int, ...]


@dataclass(frozen=True)
class Instances:
    """All instances of a scene.

    Attributes
    ----------
    of : dict of int to list of Instance
        By the session number of the object that instances them.
    further : int
        Number of those that were left out, above `MOST_INSTANCES`.
    """

    of: dict[int, list[Instance]]
    further: int


def is_carrier(item: Any) -> bool:
    """Whether an object may instance others.

    Parameters
    ----------
    item : bpy.types.Object

    Returns
    -------
    carrier : bool
        Nodes tell only once they are evaluated.
    """
    if item.instance_type == "COLLECTION":
        return item.instance_collection is not None
    if item.instance_type in ("VERTS", "FACES"):
        return True
    particles = (system.settings.render_type for system in item.particle_systems)
    return any(kind in ("OBJECT", "COLLECTION") for kind in particles) or any(
        modifier.type == "NODES" and modifier.node_group is not None and modifier.show_viewport
        for modifier in item.modifiers
    )


def show_realized(items: Iterable[Any]) -> None:
    """Have nodes show instances that they turn into one mesh in the end; for a file that is only read.

    Parameters
    ----------
    items : iterable of bpy.types.Object
    """
    groups = {
        modifier.node_group for item in items for modifier in item.modifiers if modifier.type == "NODES"
    }
    for group in groups - {None}:
        for link in group.links:
            if link.to_node.bl_idname == "NodeGroupOutput" and link.from_node.bl_idname == _REALIZE:
                link.from_node.mute = True


def collect_instances(
    depsgraph: Any, types: Iterable[str], read: Callable[[Any], int | None], belongs: Callable[[Any], bool]
) -> Instances:
    """Collect what the objects of an evaluated scene instance.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    types : iterable of str
        Types of objects that have a mesh.
    read : callable
        Stores the mesh of an evaluated object and returns its number, None if it has none. Called for meshes
        that belong to no object of the file, each once.
    belongs : callable
        Whether an object's mesh is read with the objects of the file.

    Returns
    -------
    instances : Instances
    """
    types = frozenset(types)
    found: dict[int, list[Instance]] = {}
    numbers: dict[int, int | None] = {}
    own_meshes: dict[int, int] = {}
    count = further = 0
    for instance in depsgraph.object_instances:
        if not instance.is_instance or instance.object.type not in types:
            continue
        shown, original, carrier = instance.object, instance.object.original, instance.parent.original
        path = tuple(number for number in instance.persistent_id if number != _NO_NUMBER)
        uid = original.session_uid
        if shown.type == "MESH" and original.type != "MESH" and (original != carrier or len(path) == 1):
            continue  # the surface of a curve or text, which is listed itself
        if original == carrier and len(path) == 1:
            continue
        if uid not in own_meshes:
            data = original.evaluated_get(depsgraph).data
            own_meshes[uid] = 0 if data is None else data.as_pointer()
        count += 1
        if count > MOST_INSTANCES:
            further += 1
            continue
        mesh: int | None = None
        pointer = shown.data.as_pointer()
        if pointer != own_meshes[uid] or not belongs(original):
            if pointer not in numbers:
                numbers[pointer] = read(shown)
            mesh = numbers[pointer]
            if mesh is None:
                continue
        found.setdefault(carrier.session_uid, []).append(
            # What the iterator gives lasts only until its next step.
            Instance(uid, mesh, instance.matrix_world.copy(), instance.parent.matrix_world.copy(), path[1:])
        )
    return Instances(found, further)
