# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects, collections and their meshes as they are noted when a file or the open scene is read.

Objects are known here by their numbers: while the open scene is read, they may be deleted. It imports nothing
but Blender's vectors and its neighbours, since `reader` runs in a Blender without this add-on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from mathutils import Matrix

from .assets import catalog_of, tags_of
from .colors import color_of
from .instancers import is_carrier

__all__ = ["SHAPE_TYPES", "Group", "Item", "State", "group_of", "item_of", "other_kind"]

SHAPE_TYPES = {
    "MESH": "object",
    "POINTCLOUD": "point cloud",
    "CURVE": "curve",
    "FONT": "text",
    "SURFACE": "surface",
    "META": "metaball",
}
"""Types of objects that have a mesh once they are evaluated, and what their shapes are called."""

# What objects without a mesh are called in the report.
_OTHERS = {
    "GPENCIL": "grease pencil",
    "GREASEPENCIL": "grease pencil",
    "CURVES": "hair object",
    "LIGHT_PROBE": "light probe",
}


@dataclass(frozen=True)
class Item:
    """An object.

    Attributes
    ----------
    uid : int
        Its session number.
    name : str
    kind : str
        What its shape is called; of an object that has none, how the report calls it.
    has_mesh : bool
        Whether its type has a mesh.
    carries : bool
        Whether it may instance others.
    is_local : bool
        Whether it is in the file, not in a linked one.
    data : int
        Session number of its data, 0 without any.
    data_name : str
    collection : int
        Session number of the collection that it instances; 0 for none.
    collection_name : str
    tags : tuple of str
    catalog : str
    color : tuple of float or None
        See `colors.color_of`.
    """

    uid: int
    name: str
    kind: str
    has_mesh: bool
    carries: bool
    is_local: bool
    data: int
    data_name: str
    collection: int
    collection_name: str
    tags: tuple[str, ...]
    catalog: str
    color: tuple[float, float, float] | None


@dataclass(frozen=True)
class Group:
    """A collection.

    Attributes
    ----------
    uid : int
        Its session number.
    name : str
    is_local, is_asset : bool
    offset : mathutils.Matrix
        Where its instances have their origin.
    members : frozenset of int
        Session numbers of the objects in it that have a mesh.
    tags : tuple of str
    catalog : str
    """

    uid: int
    name: str
    is_local: bool
    is_asset: bool
    offset: Any
    members: frozenset[int]
    tags: tuple[str, ...]
    catalog: str


@dataclass(frozen=True)
class State:
    """An object's mesh at a frame.

    Attributes
    ----------
    matrix : mathutils.Matrix
        To the world.
    content : bytes
        See `SharedMeshes`.
    mesh : int
        Its number.
    """

    matrix: Any
    content: bytes
    mesh: int


def item_of(item: Any, catalogs: Mapping[str, str]) -> Item:
    """Note what is known of an object without its mesh.

    Parameters
    ----------
    item : bpy.types.Object
    catalogs : mapping of str to str
        See `assets.catalogs_for`.

    Returns
    -------
    item : Item
    """
    data, collection = item.data, item.instance_collection
    carries = is_carrier(item)
    instances = carries and item.instance_type == "COLLECTION"
    return Item(
        uid=item.session_uid,
        name=item.name,
        kind=SHAPE_TYPES.get(item.type) or other_kind(item.type),
        has_mesh=item.type in SHAPE_TYPES,
        carries=carries,
        is_local=item.library is None,
        data=0 if data is None else data.session_uid,
        data_name="" if data is None else data.name,
        collection=collection.session_uid if instances else 0,
        collection_name=collection.name if instances else "",
        tags=tuple(tags_of(item)),
        catalog=catalog_of(item, catalogs),
        color=color_of(item),
    )


def group_of(collection: Any, catalogs: Mapping[str, str]) -> Group:
    """Note what is known of a collection.

    Parameters
    ----------
    collection : bpy.types.Collection
    catalogs : mapping of str to str

    Returns
    -------
    group : Group
    """
    return Group(
        uid=collection.session_uid,
        name=collection.name,
        is_local=collection.library is None,
        is_asset=collection.asset_data is not None and collection.library is None,
        offset=Matrix.Translation(collection.instance_offset),
        members=frozenset(item.session_uid for item in collection.all_objects if item.type in SHAPE_TYPES),
        tags=tuple(tags_of(collection)),
        catalog=catalog_of(collection, catalogs),
    )


def other_kind(object_type: str) -> str:
    """Say what an object without a mesh is, by its type in Blender."""
    return _OTHERS.get(object_type, object_type.lower().replace("_", " "))
