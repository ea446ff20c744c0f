# SPDX-License-Identifier: GPL-3.0-or-later
"""How many objects of a file are evaluated together: so many that it is quick, so few that memory suffices.

It imports nothing but Python's own modules, since `reader` runs in a Blender without this add-on.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

__all__ = ["Portions", "Together", "computed_faces", "evaluated_together"]


@dataclass(frozen=True)
class Together:
    """Objects that have to be, or should be, evaluated in one scene.

    Attributes
    ----------
    items : tuple of bpy.types.Object
    weight : int
        How many objects Blender evaluates for them, about.
    """

    items: tuple[Any, ...]
    weight: int


class Portions:
    """Takes objects from a queue in portions that grow until their meshes are large.

    Parameters
    ----------
    most_objects, most_faces : int
        Of a portion; what belongs together may be more.

    Attributes
    ----------
    weight : int
        Number of objects that Blender evaluates for the last portion, about.
    """

    def __init__(self, most_objects: int, most_faces: int) -> None:
        self._most_objects, self._most_faces = most_objects, most_faces
        self._size = 1
        self._taken = self.weight = 0

    def take(self, waiting: deque[Together]) -> list[Any]:
        """Take the next portion, at least one entry.

        Parameters
        ----------
        waiting : deque of Together

        Returns
        -------
        objects : list of bpy.types.Object
        """
        some: dict[Any, None] = {}
        self._taken = self.weight = 0
        while waiting and (
            not self._taken
            or (self._taken < self._size and self.weight + waiting[0].weight <= self._most_objects)
        ):
            entry = waiting.popleft()
            some.update(dict.fromkeys(entry.items))
            self.weight += entry.weight
            self._taken += 1
        return list(some)

    def note(self, faces: int) -> None:
        """Learn how many faces the last portion had.

        Parameters
        ----------
        faces : int
        """
        self._size = max(1, min(2 * self._taken, self._taken * self._most_faces // max(faces, 1)))


def evaluated_together(items: Iterable[Any]) -> list[Together]:
    """Group objects that instance others: what shows one collection belongs together, and so do children.

    Parameters
    ----------
    items : iterable of bpy.types.Object

    Returns
    -------
    groups : list of Together
    """
    sizes: dict[int, int] = {}
    groups: dict[object, dict[Any, None]] = {}
    weights: dict[object, int] = {}
    for item in items:
        collection = item.instance_collection if item.instance_type == "COLLECTION" else None
        # With modifiers it has a mesh of its own, which may be large.
        key: object = item if collection is None or item.modifiers else collection.session_uid
        # On vertices and faces an object instances its children.
        children = item.children_recursive if item.instance_type in ("VERTS", "FACES") else ()
        groups.setdefault(key, {}).update(dict.fromkeys((item, *children)))
        weights[key] = 1 + len(children) + (0 if collection is None else _size(collection, sizes))
    return [Together(tuple(group), weights[key]) for key, group in groups.items()]


def computed_faces(item: Any, depsgraph: Any) -> int:
    """Count the faces of an object's mesh if its nodes have made it.

    Parameters
    ----------
    item : bpy.types.Object
    depsgraph : bpy.types.Depsgraph

    Returns
    -------
    faces : int
    """
    if item.type != "MESH" or all(modifier.type != "NODES" for modifier in item.modifiers):
        return 0
    return len(item.evaluated_get(depsgraph).data.polygons)


def _size(collection: Any, sizes: dict[int, int]) -> int:
    """Count the objects that an instance of a collection shows, those of collections in it too."""
    uid = collection.session_uid
    if uid not in sizes:
        sizes[uid] = 0  # of one that contains itself
        objects = collection.all_objects
        inner = [item.instance_collection for item in objects if item.instance_type == "COLLECTION"]
        sizes[uid] = len(objects) + sum(_size(one, sizes) for one in inner if one is not None)
    return sizes[uid]
