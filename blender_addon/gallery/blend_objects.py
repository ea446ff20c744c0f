# SPDX-License-Identifier: GPL-3.0-or-later
"""Find an object in another .blend file that may have been renamed since the file was indexed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from ..scene.finding import Sought, is_alike
from .errors import PlacingError

__all__ = ["name_in"]


def name_in(context: Any, path: Path, sought: Sought) -> str:
    """Return the name that an object has in a file now: by its name, otherwise by its mesh.

    Parameters
    ----------
    context : bpy.types.Context
        In object mode. The scene is as before afterwards.
    path : Path
        Of the file.
    sought : Sought

    Returns
    -------
    name : str

    Raises
    ------
    PlacingError
        If the file has no such object.
    RuntimeError
        If Blender cannot read the file.
    """
    with bpy.data.libraries.load(str(path), link=True, assets_only=False) as (content, _):
        names, collections = list(content.objects), list(content.collections)
    if sought.object_name in (collections if sought.is_collection else names):
        return sought.object_name
    if sought.is_collection:
        raise PlacingError(
            "{file!r} contains no collection {name!r} any more; Index Library reads the changed file, then "
            "search again",
            file=path.name,
            name=sought.object_name,
        )
    for name in _candidates(path, names, sought):
        if _has(context, path, name, sought):
            return name
    raise PlacingError(
        "{file!r} contains no object {name!r} any more, nor its mesh under another name; Index Library reads "
        "the changed file, then search again",
        file=path.name,
        name=sought.object_name,
    )


def _candidates(path: Path, names: list[str], sought: Sought) -> list[str]:
    """Objects that may have the mesh: modifiers can change the number of its vertices."""
    if not sought.vertex_count:
        return []
    with bpy.data.temp_data() as data:
        with data.libraries.load(str(path), link=False) as (_, wanted):
            wanted.objects = names
        return [
            item.name
            for item in wanted.objects
            if item is not None
            and (
                (item.type == "MESH" and (item.modifiers or len(item.data.vertices) == sought.vertex_count))
                or (item.type == "POINTCLOUD" and len(item.data.points) == sought.vertex_count)
            )
        ]


def _has(context: Any, path: Path, name: str, sought: Sought) -> bool:
    """Whether an object has the mesh once it is evaluated, for which it is brought in and removed again."""
    selected, active = list(context.view_layer.objects.selected), context.view_layer.objects.active
    before, shown = set(bpy.data.user_map()), set(context.view_layer.objects)
    bpy.ops.wm.append(directory=f"{path}/Object/", filename=name, autoselect=False)
    try:
        context.view_layer.update()
        new = [item for item in context.view_layer.objects if item not in shown]
        return any(is_alike(item, sought) for item in new)
    finally:
        bpy.data.batch_remove([block for block in bpy.data.user_map() if block not in before])
        context.view_layer.update()
        for item in context.view_layer.objects:
            item.select_set(item in selected)
        context.view_layer.objects.active = active
