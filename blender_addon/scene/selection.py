# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects can be shapes, and which of them Blender evaluates; reads no mesh, so it suits panels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from ..reading.records import SHAPE_TYPES
from ..translation import tr

__all__ = [
    "CARRIERS",
    "asset_tags",
    "collection_for_new",
    "joined_name",
    "mesh_objects",
    "meshes_of",
    "query_objects",
    "searched_objects",
    "shape_objects",
    "split_evaluated",
]

CARRIERS = ("ARMATURE", "LATTICE", "EMPTY")
"""Types of objects without a surface that carry or deform meshes; an artist selects them in their place."""


def collection_for_new(context: Any) -> Any:
    """Return the collection that new objects go into.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    collection : bpy.types.Collection
        The active one; where it cannot be changed or seen, that of the scene, as Blender does.
    """
    active = context.collection
    is_linked = active.library is not None or active.override_library is not None
    if is_linked or context.view_layer.active_layer_collection.exclude:
        return context.scene.collection
    return active


def mesh_objects(objects: Sequence[Any]) -> list[Any]:
    """Return the objects that are meshes, in the same order."""
    return [item for item in objects if item.type == "MESH"]


def shape_objects(objects: Sequence[Any]) -> list[Any]:
    """Return the objects that may be shapes, such as meshes, point clouds and curves, in the same order."""
    return [item for item in objects if item.type in SHAPE_TYPES]


def query_objects(objects: Sequence[Any]) -> list[Any]:
    """Return the objects that may stand for a shape, in the same order; cheap enough for panels.

    Parameters
    ----------
    objects : sequence of bpy.types.Object

    Returns
    -------
    items : list of bpy.types.Object
        Objects that may be shapes, and rigs, lattices and empties, whose meshes `meshes_of` finds.
    """
    return [item for item in objects if item.type in SHAPE_TYPES or item.type in CARRIERS]


def searched_objects(context: Any) -> frozenset[int]:
    """Return the session uids of the selected objects, and of the meshes that they stand for.

    Parameters
    ----------
    context : bpy.types.Context
        If nothing is selected, its active object is used.
    """
    chosen = context.selected_objects or [item for item in [context.active_object] if item is not None]
    parts = [part for item in chosen for part in meshes_of(item, context) or shape_objects([item])]
    return frozenset(part.session_uid for part in parts)


def meshes_of(item: Any, context: Any) -> list[Any]:
    """Return the mesh objects that an object stands for.

    Parameters
    ----------
    item : bpy.types.Object
    context : bpy.types.Context
        Its view layer is used.

    Returns
    -------
    meshes : list of bpy.types.Object
        A mesh itself. For a rig, a lattice or an empty: the visible meshes that it deforms, or that are its
        children, or theirs; of a collection instance, the meshes of the collection. For others none.
    """
    if item.type == "MESH":
        return [item]
    if item.type not in CARRIERS:
        return []
    if item.instance_type == "COLLECTION" and item.instance_collection is not None:
        return mesh_objects(item.instance_collection.all_objects)
    return [
        other
        for other in mesh_objects(context.view_layer.objects)
        if (_is_deformed_by(other, item) or _is_below(other, item))
        and other.visible_get(view_layer=context.view_layer)
    ]


def _is_deformed_by(item: Any, carrier: Any) -> bool:
    return any(
        modifier.type in ("ARMATURE", "LATTICE", "HOOK") and modifier.object == carrier
        for modifier in item.modifiers
    )


def _is_below(item: Any, ancestor: Any) -> bool:
    parent = item.parent
    while parent is not None and parent != ancestor:
        parent = parent.parent
    return parent is not None


def split_evaluated(objects: Iterable[Any], context: Any) -> tuple[list[Any], list[Any]]:
    """Separate the objects that Blender evaluates in the view layer from those that it does not.

    Blender does not evaluate objects that are disabled in viewports or only in excluded collections. Such an
    object has no modifiers applied, and after opening a file its ``matrix_world`` is the identity: its place
    and size are unknown. Objects hidden with the eye are evaluated.

    Parameters
    ----------
    objects : iterable of bpy.types.Object
    context : bpy.types.Context
        Its view layer is used.

    Returns
    -------
    evaluated, others : list of bpy.types.Object
        Both in the order given. The world matrices of the first are up to date.
    """
    depsgraph = context.evaluated_depsgraph_get()
    enabled = _enabled_objects(context.view_layer.layer_collection)
    evaluated: list[Any] = []
    others: list[Any] = []
    for item in objects:
        # Being in the graph is not enough: objects that others refer to are there in part, without their
        # modifiers, and objects that an animation disables keep an outdated matrix.
        own = item.evaluated_get(depsgraph)
        seen = item in enabled and own.is_evaluated and not own.hide_viewport
        (evaluated if seen else others).append(item)
    return evaluated, others


def asset_tags(item: Any) -> tuple[str, ...]:
    """Return the tags of an object that is marked as an asset; none for others."""
    return () if item.asset_data is None else tuple(tag.name for tag in item.asset_data.tags)


def joined_name(names: Sequence[str]) -> str:
    """Return the first name, and how many more there are."""
    if len(names) == 1:
        return names[0]
    return tr("{name} and {count} more").format(name=names[0], count=len(names) - 1)


def _enabled_objects(layer: Any, *, disabled: bool = False) -> set[Any]:
    """Objects of a layer collection and those below it whose collections do not keep them from being seen."""
    disabled = (
        disabled or layer.collection.hide_viewport
    )  # passed on to collections inside, as `exclude` is not
    found = set() if disabled or layer.exclude else set(layer.collection.objects)
    for child in layer.children:
        found |= _enabled_objects(child, disabled=disabled)
    return found
