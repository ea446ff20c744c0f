# SPDX-License-Identifier: GPL-3.0-or-later
"""The groups that are listed of a scene follow it: objects are deleted, renamed, linked, and all is undone.

What was found is remembered by the session numbers of the objects, so that groups that linking has settled
come back when it is undone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent

from .. import jobs, state

if TYPE_CHECKING:
    from .groups import Group

__all__ = ["Found", "refresh_groups", "register", "remember", "unregister"]

# While objects are moved, the scene changes many times a second.
SECONDS_OF_REST = 0.5


@dataclass(frozen=True)
class Found:
    """A group as it was found.

    Attributes
    ----------
    group : Group
    uids : tuple of int
        Session number of the object of each member; 0 if there is none.
    meshes : int
        Number of different meshes of these objects.
    """

    group: Group
    uids: tuple[int, ...]
    meshes: int


def remember(groups: Sequence[Group], *, add: bool) -> None:
    """Remember the groups that were found in the scene.

    Parameters
    ----------
    groups : sequence of Group
    add : bool
        Keep those that are remembered.
    """
    by_name = {
        (item.name, "" if item.library is None else item.library.filepath): item
        for item in bpy.context.scene.objects
    }
    found = state.current().duplicates.found
    if not add:
        found.clear()
    for group in groups:
        objects = [by_name.get((member.name, member.library)) for member in group.members]
        uids = tuple(0 if item is None else item.session_uid for item in objects)
        meshes = len({item.data.session_uid for item in objects if item is not None})
        found.append(Found(group, uids, meshes))


def refresh_groups(context: Any) -> None:
    """List the groups as they are now: without deleted objects, under new names, without what shares a mesh.

    Parameters
    ----------
    context : bpy.types.Context
    """
    from .background import summary
    from .properties import show_groups

    shown, found = context.window_manager.shape_google_duplicates, state.current().duplicates.found
    if not found or shown.found_in != "SCENE" or shown.running:
        return
    by_uid = {item.session_uid: item for item in context.scene.objects if item.type == "MESH"}
    groups = [group for group in (_today(entry, by_uid) for entry in found) if group is not None]
    if [_key(group.members, group.meshes) for group in groups] == [
        _key(group.members, group.meshes) for group in shown.groups
    ]:
        return
    chosen = {member.name for group in shown.groups if group.chosen for member in group.members}
    index = shown.index
    show_groups(shown, groups, "SCENE", new=False)
    for group in shown.groups:
        group.chosen = group.linkable and any(member.name in chosen for member in group.members)
    shown.index = min(index, max(0, len(groups) - 1))
    shown.status = summary(shown)
    jobs.redraw()


def _key(members: Any, meshes: int) -> tuple[Any, ...]:
    return (meshes, *(member.name for member in members))


def _today(found: Found, by_uid: dict[int, Any]) -> Group | None:
    """Return what is left of a group; None if all that is left shares one mesh."""
    pairs = zip(found.group.members, found.uids, strict=True)
    left = [(member, by_uid[uid]) for member, uid in pairs if uid in by_uid]
    meshes = len({item.data.session_uid for _, item in left})
    if meshes < 2:
        return None
    members = tuple(replace(member, name=item.name) for member, item in left)
    if meshes == found.meshes:
        return replace(found.group, members=members)
    faces = round(found.group.saved_faces * (meshes - 1) / (found.meshes - 1))
    return replace(found.group, members=members, meshes=meshes, saved_faces=faces)


def _look() -> None:
    if state.is_registered():
        refresh_groups(bpy.context)


@persistent
def _note_change(*_arguments: object) -> None:
    """Objects may have been deleted or renamed: look in a moment."""
    waits = bpy.app.timers.is_registered(_look)
    if state.current().duplicates.found and not (waits or bpy.app.background):
        bpy.app.timers.register(_look, first_interval=SECONDS_OF_REST)


@persistent
def _note_undo(*_arguments: object) -> None:
    refresh_groups(bpy.context)


_HANDLERS = {"depsgraph_update_post": _note_change, "undo_post": _note_undo, "redo_post": _note_undo}


def register() -> None:
    """Register the handlers."""
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    """Unregister the handlers."""
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
