# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects of the open scene that are members of a group."""

from __future__ import annotations

from typing import Any

from .. import state
from ..library.open_file import is_open_file, open_source
from ..scene.finding import SceneObjects, Sought
from ..translation import tr

__all__ = ["is_in_object_mode", "objects_by_name", "objects_of"]

ObjectsByName = dict[tuple[str, str], Any]


def is_in_object_mode(operator: Any, context: Any) -> bool:
    """Whether objects can be selected and changed; if not, the operator's button says why."""
    if context.mode != "OBJECT":
        operator.poll_message_set(tr("Switch to object mode"))
        return False
    return True


def objects_by_name(context: Any) -> ObjectsByName:
    """Objects of the scene by their name and the file that they are linked from."""
    return {
        (item.name, "" if item.library is None else item.library.filepath): item
        for item in context.scene.objects
    }


def objects_of(context: Any, group: Any, by_name: ObjectsByName, found_in: str) -> list[Any]:
    """Return the members of a group that are in the scene, under whatever name they have now.

    Parameters
    ----------
    context : bpy.types.Context
    group : SHAPEGOOGLE_PG_duplicate_group
    by_name : dict
        As from `objects_by_name`, made once for many groups.
    found_in : {"SCENE", "LIBRARY"}

    Returns
    -------
    objects : list of bpy.types.Object
        Each once.
    """
    if found_in == "LIBRARY":
        here, numbers = SceneObjects(context), state.current().library.objects
        source = open_source()
        found = [
            here.find(Sought(member.name, numbers.get((source, member.name), 0)))
            for member in group.members
            if is_open_file(member.source)
        ]
    else:
        found = [by_name.get((member.name, member.library)) for member in group.members]
        found = [item for item in found if item is not None and item.type == "MESH"]
    return list(dict.fromkeys(item for item in found if item is not None))
