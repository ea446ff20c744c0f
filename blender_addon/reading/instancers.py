# SPDX-License-Identifier: GPL-3.0-or-later
"""What objects instance: collections, geometry nodes, particles and vertices, as Blender shows it.

It imports nothing but Python's own modules, since `reader` runs in a Blender without this add-on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import islice
from typing import Any

__all__ = ["MOST_INSTANCES", "Instance", "InstanceCollector", "is_carrier", "show_realized"]

MOST_INSTANCES = 50_000
"""Instances of one file that are taken into account; a lawn may have millions."""

# Blender fills the numbers of an instance up with the largest one.
_NO_NUMBER = 2**31 - 1
_REALIZE = "GeometryNodeRealizeInstances"
# Modifiers that Blender computes only when it is asked for the mesh.
_LATE = {"SUBSURF", "MULTIRES"}
# Instances from one look at the clock to the next: each takes some millionths of a second.
_INSTANCES_BETWEEN_LOOKS = 500
# How often a scene that changes while it is read is begun again.
_MOST_RESTARTS = 3


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


class InstanceCollector:
    """Collects what the objects of evaluated scenes instance, one scene after the other.

    Parameters
    ----------
    types : iterable of str
        Types of objects that have a mesh.
    read : callable
        Stores the mesh of an evaluated object and returns its number, None if it has none. Called for meshes
        that belong to no object of the file; for one that it gave a number it should give the same again.
    belongs : callable
        Whether an object's mesh is read with the objects of the file.
    only : int, optional
        Session number of the one object whose instances are wanted.

    Attributes
    ----------
    of : dict of int to list of Instance
        By the session number of the object that instances them.
    further : int
        Number of those that were left out, above `MOST_INSTANCES`.
    faces : int
        Faces that Blender has computed for what was instanced in the last scene.
    """

    def __init__(
        self,
        types: Iterable[str],
        read: Callable[[Any], int | None],
        belongs: Callable[[Any], bool],
        only: int | None = None,
    ) -> None:
        self._types = frozenset(types)
        self._only = only
        self._read = read
        self._belongs = belongs
        self.of: dict[int, list[Instance]] = {}
        self.further = self.faces = 0
        self._count = 0
        # Objects of earlier scenes: one that was evaluated since another one needs it is no news.
        self._closed: frozenset[int] = frozenset()
        self._closed_further = 0
        self._position = 0
        self._last: tuple[object, ...] = ()
        self._restarts = 0

    def collect(self, depsgraph: Any, has_time: Callable[[], bool] = lambda: True) -> bool:
        """Collect from a scene, or go on where the last call ran out of time.

        If the scene has changed meanwhile, its instances may have another order: it is begun again then. A
        scene that changes all the time, such as one that is played, is read at a stretch in the end.

        Parameters
        ----------
        depsgraph : bpy.types.Depsgraph
        has_time : callable, optional
            Asked now and then.

        Returns
        -------
        complete : bool
            Whether the scene has no more.
        """
        rest = islice(depsgraph.object_instances, max(self._position - 1, 0), None)
        if not self._position:
            self.faces = 0
        elif not any(_identity(before) == self._last for before in islice(rest, 1)):
            self._restarts += 1
            self._begin_again()
            rest = islice(depsgraph.object_instances, None)
        # Numbers of meshes by their addresses, which say nothing any more once something is evaluated anew.
        meshes: dict[int, int | None] = {}
        own: dict[int, int | None] = {}
        for position, instance in enumerate(rest, self._position + 1):
            self._take(instance, depsgraph, meshes, own)
            if not position % _INSTANCES_BETWEEN_LOOKS and self._restarts < _MOST_RESTARTS and not has_time():
                self._position, self._last = position, _identity(instance)
                return False
        self._closed |= frozenset(self.of)
        self._closed_further = self.further
        self._position, self._restarts = 0, 0
        return True

    def _begin_again(self) -> None:
        self._count -= sum(len(own) for uid, own in self.of.items() if uid not in self._closed)
        self.of = {uid: own for uid, own in self.of.items() if uid in self._closed}
        self._position, self.further = 0, self._closed_further

    def _take(
        self, instance: Any, depsgraph: Any, meshes: dict[int, int | None], own: dict[int, int | None]
    ) -> None:
        if not instance.is_instance:
            return
        shown = instance.object
        if shown.type not in self._types:
            return
        original, carrier = shown.original, instance.parent.original
        number = carrier.session_uid
        if number in self._closed or self._only not in (None, number):
            return
        path = tuple([step for step in instance.persistent_id if step != _NO_NUMBER])
        uid, is_alone = original.session_uid, len(path) == 1
        if shown.type == "MESH" and original.type != "MESH" and (is_alone or original != carrier):
            return  # the surface of a curve or text, which is listed itself
        if is_alone and original == carrier:
            return
        if self._count >= MOST_INSTANCES:
            self.further += 1
            return
        if uid not in own:
            own[uid] = self._own_mesh(original, carrier, depsgraph)
        mesh: int | None = None
        if own[uid] is not None and (pointer := shown.data.as_pointer()) != own[uid]:
            if pointer not in meshes:
                meshes[pointer] = self._read(shown)
            mesh = meshes[pointer]
            if mesh is None:
                return
        self._count += 1
        self.of.setdefault(number, []).append(
            # What the iterator gives lasts only until its next step.
            Instance(uid, mesh, instance.matrix_world.copy(), instance.parent.matrix_world.copy(), path[1:])
        )

    def _own_mesh(self, original: Any, carrier: Any, depsgraph: Any) -> int | None:
        """Address of the mesh that is read with the objects of the file, 0 if none is.

        None if an object shows no other mesh than its own: others are shown in its name only by nodes. To ask
        for the address has Blender compute the mesh, which takes long for a subdivided one.
        """
        kinds = {modifier.type for modifier in original.modifiers}
        belongs, may_show_others = self._belongs(original), "NODES" in kinds or original == carrier
        if original.type == "MESH" and kinds and (may_show_others or kinds.isdisjoint(_LATE)):
            self.faces += len(original.evaluated_get(depsgraph).data.polygons)
        if belongs and not may_show_others:
            return None
        data = original.evaluated_get(depsgraph).data
        return 0 if data is None or not belongs else int(data.as_pointer())


def _identity(instance: Any) -> tuple[object, ...]:
    """Say which instance, or object, this is, and where."""
    carrier = instance.parent.original.session_uid if instance.is_instance else 0
    place = tuple(instance.matrix_world.translation)
    return carrier, instance.object.original.session_uid, tuple(instance.persistent_id), place
