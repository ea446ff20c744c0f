# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the object of the open scene that a shape of the library is, renamed or not."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import bpy

from .selection import shape_objects

__all__ = ["SceneObjects", "Sought", "is_alike"]

# Relative difference of areas up to which two meshes of the same counts are the same: both are computed from
# single precision.
SAME_AREA = 1e-4


@dataclass(frozen=True)
class Sought:
    """What is known of an object that may have been renamed.

    Attributes
    ----------
    object_name : str
        Its name when it was indexed.
    session_uid : int
        Blender's number of it in this session; 0 if it is not known.
    vertex_count, face_count : int
        Of its evaluated mesh, cut into triangles; no vertices if they are not known.
    area : float
        Of its evaluated mesh in the world.
    shape_type : str
        What it is in its file; see `shapegoogle_core.library.origin.SHAPE_TYPES`.
    """

    object_name: str
    session_uid: int = 0
    vertex_count: int = 0
    face_count: int = 0
    area: float = 0.0
    shape_type: str = ""

    @property
    def is_collection(self) -> bool:
        """Whether it is a collection, not an object."""
        return self.shape_type == "collection"


class SceneObjects:
    """The objects of a scene, to find several by number, name or content; not to be kept.

    Parameters
    ----------
    context : bpy.types.Context
    """

    def __init__(self, context: Any) -> None:
        self._context = context
        self._objects = list(context.scene.objects)
        self._by_uid = {item.session_uid: item for item in self._objects}
        self._by_name = {item.name: item for item in self._objects if item.library is None}
        self._by_count: defaultdict[int, list[Any]] | None = None
        self._instancers: dict[str, list[Any]] | None = None
        self._facts: dict[int, tuple[int, float]] = {}

    def find(self, sought: Sought) -> Any | None:
        """Find an object: by its number, by its name, then by its content.

        Parameters
        ----------
        sought : Sought

        Returns
        -------
        item : bpy.types.Object or None
        """
        if sought.session_uid in self._by_uid:
            return self._by_uid[sought.session_uid]
        if sought.is_collection:
            return next(iter(self.of_collection(sought.object_name)), None)
        named = self._by_name.get(sought.object_name)
        # Without its number, the name decides: its mesh may have been edited since.
        if named is not None and not sought.session_uid:
            return named
        alike = self._alike(sought)
        if named is not None or alike:
            return named if named in alike else next(iter(alike), None)
        return next(iter(self.instancers(sought.object_name)), None)

    def instancers(self, object_name: str) -> list[Any]:
        """Return the objects that instance an object of some name."""
        if self._instancers is None:
            found: defaultdict[str, dict[Any, None]] = defaultdict(dict)
            for instance in self._context.evaluated_depsgraph_get().object_instances:
                if instance.is_instance and instance.parent is not None:
                    found[instance.object.original.name][instance.parent.original] = None
            self._instancers = {name: list(carriers) for name, carriers in found.items()}
        return [item for item in self._instancers.get(object_name, []) if item.name != object_name]

    def of_collection(self, name: str) -> list[Any]:
        """Return the objects that show a collection: those that instance it, and those that are in it."""
        collection = bpy.data.collections.get(name)
        if collection is None:
            return []
        instancing = [item for item in self._objects if item.instance_collection == collection]
        inside = set(collection.all_objects)
        return [*[item for item in self._objects if item in inside], *instancing]

    def _alike(self, sought: Sought) -> list[Any]:
        """Objects whose evaluated meshes have the counts and the area that are sought."""
        if not sought.vertex_count:
            return []
        depsgraph = self._context.evaluated_depsgraph_get()
        if self._by_count is None:
            self._by_count = defaultdict(list)
            for item in shape_objects(self._objects):
                if item.type in ("MESH", "POINTCLOUD"):  # others are found by their names alone
                    data = item.evaluated_get(depsgraph).data
                    points = data.points if item.type == "POINTCLOUD" else data.vertices
                    self._by_count[len(points)].append(item)
        return [
            item
            for item in self._by_count[sought.vertex_count]
            if _same(self._facts_of(item, depsgraph), sought)
        ]

    def _facts_of(self, item: Any, depsgraph: Any) -> tuple[int, float]:
        if item.session_uid not in self._facts:
            self._facts[item.session_uid] = _facts(item, depsgraph)
        return self._facts[item.session_uid]


def is_alike(item: Any, sought: Sought) -> bool:
    """Whether an object has the evaluated mesh that is sought, whatever its name.

    Parameters
    ----------
    item : bpy.types.Object
        In the view layer of the context.
    sought : Sought
    """
    if item.type not in ("MESH", "POINTCLOUD") or not sought.vertex_count:
        return False
    from .meshes import evaluated_mesh

    mesh = evaluated_mesh(item)
    return len(mesh.vertices) == sought.vertex_count and _same((len(mesh.faces), mesh.area), sought)


def _facts(item: Any, depsgraph: Any) -> tuple[int, float]:
    from shapegoogle_core import MeshError

    from .meshes import evaluated_mesh

    try:
        mesh = evaluated_mesh(item, depsgraph)
    except MeshError:  # broken coordinates: nothing that was indexed
        return -1, 0.0
    return len(mesh.faces), mesh.area


def _same(facts: tuple[int, float], sought: Sought) -> bool:
    faces, area = facts
    return faces == sought.face_count and abs(area - sought.area) <= SAME_AREA * max(area, sought.area)
