# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects can be shapes, and which of them Blender evaluates; reads no mesh, so it suits panels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

__all__ = ["asset_tags", "joined_name", "mesh_objects", "shape_objects", "split_evaluated"]


def mesh_objects(objects: Sequence[Any]) -> list[Any]:
    """Return the objects that are meshes, in the same order."""
    return [item for item in objects if item.type == "MESH"]


def shape_objects(objects: Sequence[Any]) -> list[Any]:
    """Return the objects that may be shapes, meshes and point clouds, in the same order."""
    return [item for item in objects if item.type in ("MESH", "POINTCLOUD")]


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
    return names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"


def _enabled_objects(layer: Any, *, disabled: bool = False) -> set[Any]:
    """Objects of a layer collection and those below it whose collections do not keep them from being seen."""
    disabled = (
        disabled or layer.collection.hide_viewport
    )  # passed on to collections inside, as `exclude` is not
    found = set() if disabled or layer.exclude else set(layer.collection.objects)
    for child in layer.children:
        found |= _enabled_objects(child, disabled=disabled)
    return found
