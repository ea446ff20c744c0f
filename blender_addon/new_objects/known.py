# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects of the open file are new: added since the last check, or since the file was opened."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.handlers import persistent

from .. import jobs, state
from ..library.present import when_it_goes
from ..scene.selection import mesh_objects
from ..state import session_of

__all__ = ["note_all", "objects_to_check", "register", "unregister"]


def note_all() -> None:
    """Note that all objects of the file are known from now on."""
    state.current().new_objects.known = {item.session_uid for item in bpy.data.objects}


def objects_to_check(context: Any, which: str, indexed: frozenset[str]) -> list[Any]:
    """Return the objects to be checked, without those that are linked from other files.

    Parameters
    ----------
    context : bpy.types.Context
    which : {"NEW", "SELECTED", "NOT_INDEXED"}
    indexed : frozenset of str
        Names of the objects of this file that are in the library; only for the last.

    Returns
    -------
    items : list of bpy.types.Object
        Meshes of the view layer.
    """
    local = [item for item in mesh_objects(context.view_layer.objects) if item.library is None]
    if which == "SELECTED":
        return [item for item in local if item.select_get()]
    if which == "NOT_INDEXED":
        return [item for item in local if item.name not in indexed]
    # What came from the gallery is from the library.
    known = state.current().new_objects.known | state.current().gallery.placed
    return [item for item in local if item.session_uid not in known]


@persistent
def _note_opened(*_arguments: object) -> None:
    """Another file is open."""
    session = session_of(bpy.context)
    session.new_objects.clear()
    session.checking, session.check_status = False, ""
    state.current().new_objects.task = None
    state.current().new_objects.signatures.clear()
    note_all()


def _forget(context: Any, reason: str) -> None:
    """Drop what was found in another library."""
    found, session = state.current().new_objects, session_of(context)
    if found.task is not None:
        found.task.cancel()
        found.task = None
    session.new_objects.clear()
    session.checking, session.check_status = False, reason
    found.signatures.clear()


def _note_first() -> None:
    """Note what is there when the add-on is switched on, once Blender allows a look at its data."""
    if state.is_registered():
        note_all()
        jobs.redraw()


def register() -> None:
    """Register the handlers."""
    bpy.app.handlers.load_post.append(_note_opened)
    when_it_goes(_forget)
    bpy.app.timers.register(_note_first, first_interval=0)


def unregister() -> None:
    """Unregister the handlers."""
    if bpy.app.timers.is_registered(_note_first):
        bpy.app.timers.unregister(_note_first)
    bpy.app.handlers.load_post.remove(_note_opened)
