# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects of the open scene that are members of a group."""

from __future__ import annotations

from typing import Any

from ..library.scene_source import is_here

__all__ = ["is_in_object_mode", "objects_by_name", "objects_of"]

ObjectsByName = dict[tuple[str, str], Any]


def is_in_object_mode(operator: Any, context: Any) -> bool:
    """Whether objects can be selected and changed; if not, the operator's button says why."""
    if context.mode != "OBJECT":
        operator.poll_message_set("Switch to object mode")
        return False
    return True


def objects_by_name(context: Any) -> ObjectsByName:
    """Objects of the scene by their name and the file that they are linked from."""
    return {
        (item.name, "" if item.library is None else item.library.filepath): item
        for item in context.scene.objects
    }


def objects_of(group: Any, by_name: ObjectsByName, found_in: str) -> list[Any]:
    """Return the members of a group that are in the scene; names may have changed since they were found.

    Parameters
    ----------
    group : SHAPEGOOGLE_PG_duplicate_group
    by_name : dict
        As from `objects_by_name`, made once for many groups.
    found_in : {"SCENE", "LIBRARY"}

    Returns
    -------
    objects : list of bpy.types.Object
    """
    if found_in == "LIBRARY":
        # Two members may be one object: indexed from the saved file, and from the open scene.
        names = [member.name for member in group.members if is_here(member.source, member.name)]
        return [by_name[name, ""] for name in dict.fromkeys(names) if (name, "") in by_name]
    members = [by_name.get((member.name, member.library)) for member in group.members]
    return [item for item in members if item is not None and item.type == "MESH"]
