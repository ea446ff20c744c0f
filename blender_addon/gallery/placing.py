# SPDX-License-Identifier: GPL-3.0-or-later
"""Append, link or import shapes of a library into the open scene."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
from mathutils import Matrix, Vector

from ..library.address import is_on_server
from ..library.open_file import is_open_file, is_unsaved
from ..reading.importers import importer_of, is_importable
from ..scene.finding import Sought
from ..scene.selection import collection_for_new
from . import blend_objects
from .errors import GONE, PlacingError

__all__ = [
    "PlacingError",
    "bounds",
    "bring_in",
    "check_place",
    "find_linked",
    "move_to",
    "remove",
    "select_only",
    "to_object_mode",
]

# Importers of Blender by suffix, besides those in `reading.importers`: module and name of the operator.
_IMPORTERS = {
    ".obj": ("wm", "obj_import"),
    ".ply": ("wm", "ply_import"),
    ".stl": ("wm", "stl_import"),
    ".glb": ("import_scene", "gltf"),
    ".gltf": ("import_scene", "gltf"),
}


def bring_in(context: Any, source: str, sought: Sought, *, link: bool = False) -> list[Any]:
    """Append or link an object of a .blend file, or import a mesh file.

    Parameters
    ----------
    context : bpy.types.Context
    source : str
        Path of the file.
    sought : Sought
        The object in a .blend or .3mf file. If none in a .blend has its name any more, it is found by its
        mesh.
    link : bool
        Link instead of append.

    Returns
    -------
    objects : list of bpy.types.Object
        The new objects, selected; the mesh objects first.

    Raises
    ------
    PlacingError
        If the file or the object in it is gone, or Blender cannot read it.
    """
    path, object_name = Path(source), sought.object_name
    if is_open_file(source):
        raise _not_here(object_name)
    if is_unsaved(source):
        raise PlacingError(
            "{name!r} is in a file that was never saved and is not open any more; Forget Missing Files "
            "removes such shapes from the library",
            name=object_name,
        )
    if is_on_server(context):
        check_place(source)
    if not path.is_file():
        raise PlacingError(
            "'{path}' does not exist any more; Move Sources tells the library where its folder is now, "
            "Forget Missing Files removes the shapes of deleted files",
            path=source,
        )
    to_object_mode(context)
    before = set(context.view_layer.objects)
    try:
        if path.suffix.lower() == ".blend":
            object_name = blend_objects.name_in(context, path, sought)
            folder = "Collection" if sought.is_collection else "Object"
            operator = bpy.ops.wm.link if link else bpy.ops.wm.append
            operator(directory=f"{path}/{folder}/", filename=object_name, autoselect=True)
        else:
            _import(context, path, object_name)
    except RuntimeError as error:
        reason = str(error).strip()
        raise PlacingError(
            "{name!r} cannot be read by Blender: {reason}", name=path.name, reason=reason
        ) from error
    # By identity, since an object that is only referred to may have the name of one of the user's.
    new = [item for item in context.view_layer.objects if item not in before]
    if not new:
        new = [_instance(context, path, object_name)]
    new.sort(key=lambda item: (item.type != "MESH", item.name != object_name, item.name))
    select_only(context, new)
    return new


def check_place(source: str) -> None:
    """Refuse a file of a library on a server that this computer does not reach.

    Parameters
    ----------
    source : str
        Path of the file, or the name of its root and the path below it.

    Raises
    ------
    PlacingError
    """
    if not os.path.isabs(source):  # noqa: PTH117 - the folder of its root is not known
        raise PlacingError(
            "The folder of '{path}' is not known on this computer; choose that of its root, the first part "
            "of this path, under Folders of Roots in the panel Library",
            path=source,
        )
    if not Path(source).is_file():
        raise PlacingError(
            "'{path}' does not exist on this computer; check the folder of its root under Folders of Roots "
            "in the panel Library",
            path=source,
        )


def remove(context: Any, blocks: Sequence[Any]) -> None:
    """Remove data that was brought in.

    Parameters
    ----------
    context : bpy.types.Context
    blocks : sequence of bpy.types.ID
    """
    bpy.data.batch_remove(blocks)
    # Until then the view layer lists None in place of each object that is gone.
    context.view_layer.update()


def find_linked(source: str, object_name: str) -> Any | None:
    """Find an object that was linked from a file before, in whatever scene.

    Parameters
    ----------
    source : str
        Path of the .blend file.
    object_name : str

    Returns
    -------
    item : bpy.types.Object or None
    """
    path = Path(source).resolve()
    for item in bpy.data.objects:
        if item.library is not None and item.name == object_name:
            linked_from = bpy.path.abspath(item.library.filepath, library=item.library.library)
            if Path(linked_from).resolve() == path:
                return item
    return None


def to_object_mode(context: Any) -> None:
    """Leave edit mode and the like, where no other object can be selected.

    Parameters
    ----------
    context : bpy.types.Context
    """
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


def select_only(context: Any, items: Sequence[Any]) -> None:
    """Select some objects and nothing else, of whatever type, and make the first one active.

    Parameters
    ----------
    context : bpy.types.Context
        In object mode.
    items : sequence of bpy.types.Object
        At least one; all in its view layer.
    """
    objects = context.view_layer.objects
    for item in list(objects.selected):
        item.select_set(False)
    for item in items:
        item.select_set(True)
    objects.active = items[0]


def _not_here(object_name: str) -> PlacingError:
    """Say why an object of the open file, which cannot be appended to itself, is not in the scene."""
    item = bpy.data.objects.get(object_name)
    scenes = [] if item is None else [repr(scene.name) for scene in item.users_scene]
    if scenes:
        return PlacingError(
            "{name!r} is in another scene of this file, {scenes}; switch to that scene",
            name=object_name,
            scenes=", ".join(scenes),
        )
    return PlacingError(GONE, name=object_name)


def _instance(context: Any, path: Path, object_name: str) -> Any:
    """Put an object that was linked before, and that Blender therefore did not link again, into the scene."""
    item = find_linked(str(path), object_name)
    if item is None:
        raise PlacingError("{name!r} contains nothing that can be shown in this scene", name=path.name)
    if item in set(context.view_layer.objects):
        return item
    if item in set(context.scene.objects):
        raise PlacingError(
            "{name!r} is linked already, in a collection that this view layer excludes: {collections}; "
            "include it",
            name=object_name,
            collections=", ".join(repr(collection.name) for collection in item.users_collection),
        )
    collection_for_new(context).objects.link(item)
    return item


def _import(context: Any, path: Path, object_name: str) -> None:
    suffix = path.suffix.lower()
    importer = importer_of(suffix)
    if importer is not None:
        importer[0](filepath=str(path))
        return
    if is_importable(suffix):
        version = bpy.app.version_string
        raise PlacingError(
            "Blender {version} does not import {suffix} files, or its importer is off in the preferences",
            version=version,
            suffix=suffix,
        )
    if suffix not in _IMPORTERS:
        _from_core(context, path, object_name)
        return
    module, name = _IMPORTERS[suffix]
    if name not in dir(getattr(bpy.ops, module)):
        raise PlacingError(
            "Blender's importer of {suffix} files is off; switch it on in the preferences", suffix=suffix
        )
    getattr(getattr(bpy.ops, module), name)(filepath=str(path))


def _from_core(context: Any, path: Path, object_name: str) -> None:
    from shapegoogle_core import MeshError
    from shapegoogle_core.mesh.io.objects import read_object

    from ..scene.meshes import new_object

    try:
        mesh = read_object(path, object_name)
    except MeshError as error:
        raise PlacingError("{reason}", reason=error) from error
    new_object(context, mesh, object_name or path.stem)
    context.view_layer.update()  # until then the view layer does not list it


def move_to(objects: list[Any], place: Vector) -> None:
    """Move new objects so that the bottom centre of the first one is at a place; linked ones stay.

    Parameters
    ----------
    objects : list of bpy.types.Object
        As from `bring_in`.
    place : Vector
    """
    bpy.context.view_layer.update()
    low, high = bounds(objects[0])
    offset = Vector(place) - Vector(((low.x + high.x) / 2, (low.y + high.y) / 2, low.z))
    for item in objects:
        # Children and what an armature moves follow their parents.
        if item.parent is None and item.library is None:
            item.matrix_world = Matrix.Translation(offset) @ item.matrix_world
    bpy.context.view_layer.update()


def bounds(item: Any) -> tuple[Vector, Vector]:
    """Return the least and the largest corner of an object's box in the world, modifiers included.

    Parameters
    ----------
    item : bpy.types.Object

    Returns
    -------
    low, high : Vector
    """
    corners = [item.matrix_world @ Vector(corner) for corner in item.bound_box]
    low = Vector(min(corner[axis] for corner in corners) for axis in range(3))
    high = Vector(max(corner[axis] for corner in corners) for axis in range(3))
    return low, high
