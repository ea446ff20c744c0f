# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects of the open scene the matches are, under whatever names they have now."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy
from bpy.app.handlers import persistent

from .. import state
from ..library.open_file import is_open_file, open_source
from ..scene.finding import SceneObjects, Sought
from ..state import session_of
from .errors import GONE, PlacingError

__all__ = [
    "WHOLES",
    "find_objects",
    "is_here",
    "object_of",
    "placements_here",
    "register",
    "sought",
    "unregister",
]


WHOLES = ("collection", "instance", "scatter")
"""Types of shapes that consist of several meshes."""


def sought(match: Any) -> Sought:
    """Return what is known of the object that a match is.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    sought : Sought
    """
    if match.shape_type in WHOLES:  # their meshes are not those of objects
        return Sought(match.object_name, match.session_uid, shape_type=match.shape_type)
    counts = match.vertex_count, match.face_count
    return Sought(match.object_name, match.session_uid, *counts, match.area, match.shape_type)


def object_of(context: Any, match: Any) -> Any | None:
    """Find the object of the open scene that a match is, under whatever name it has now.

    Parameters
    ----------
    context : bpy.types.Context
    match : SHAPEGOOGLE_PG_match

    Returns
    -------
    item : bpy.types.Object or None
        In the view layer; None for a match of another file.

    Raises
    ------
    PlacingError
        If it is gone, or in a collection that the view layer excludes.
    """
    return _usable(context, SceneObjects(context), sought(match)) if match.in_scene else None


def placements_here(context: Any, match: Any) -> list[Any]:
    """Find all objects of the open scene that show the shape of a match, the one that fits best first.

    Parameters
    ----------
    context : bpy.types.Context
    match : SHAPEGOOGLE_PG_match
        In the open scene.

    Returns
    -------
    items : list of bpy.types.Object
        Those of the view layer, at least one.

    Raises
    ------
    PlacingError
        If the best one is gone or excluded.
    """
    objects = SceneObjects(context)
    wanted = sought(match)
    if wanted.is_collection:
        here = set(context.view_layer.objects)
        items = [item for item in objects.of_collection(wanted.object_name) if item in here]
        return items or [_usable(context, objects, wanted)]
    found = [_usable(context, objects, wanted)]
    if match.placement_count > 1:
        numbers, source = state.current().library.objects, open_source()
        search = state.current().search
        names = [
            name
            for answer in (search.answer, search.versions)
            if answer is not None
            for name in answer.object_names.get(match.shape_id, ())
        ]
        here = set(context.view_layer.objects)
        for name in dict.fromkeys(names):
            item = objects.find(Sought(name, numbers.get((source, name), 0)))
            found += [other for other in (item, *objects.instancers(name)) if other in here]
    return list(dict.fromkeys(found))


def _usable(context: Any, objects: SceneObjects, wanted: Sought) -> Any:
    item = objects.find(wanted)
    if item is None:
        raise PlacingError(GONE, name=wanted.object_name)
    if item not in set(context.view_layer.objects):
        where = ", ".join(repr(collection.name) for collection in item.users_collection)
        raise PlacingError(
            "{name!r} is in a collection that this view layer excludes: {collections}; include it",
            name=item.name,
            collections=where,
        )
    return item


def is_here(match: Any) -> bool:
    """Whether a match is an object of the open scene; cheap, for panels.

    Parameters
    ----------
    match : SHAPEGOOGLE_PG_match
    """
    if not is_open_file(match.source):
        return False
    if match.session_uid:
        return match.session_uid in _numbers()
    if match.shape_type == "collection":
        return match.object_name in bpy.data.collections
    return match.object_name in bpy.context.scene.objects


def find_objects(context: Any, matches: Iterable[Any]) -> None:
    """Find the objects that matches are: they are new, or another file is open.

    Parameters
    ----------
    context : bpy.types.Context
    matches : iterable of SHAPEGOOGLE_PG_match
    """
    here, numbers, source = SceneObjects(context), state.current().library.objects, open_source()
    for match in matches:
        match.session_uid = 0
        if is_open_file(match.source):
            match.session_uid = numbers.get((source, match.object_name), 0)
            item = here.find(sought(match))
            match.session_uid = 0 if item is None else item.session_uid


def _numbers() -> set[int]:
    """Session numbers of the objects of the open scene."""
    gallery, scene = state.current().gallery, bpy.context.scene
    if gallery.numbers is None or gallery.numbers[0] != scene.session_uid:
        gallery.numbers = scene.session_uid, {item.session_uid for item in scene.objects}
    return gallery.numbers[1]


@persistent
def _count_again(*_arguments: object) -> None:
    """Objects may have been added or deleted."""
    state.current().gallery.numbers = None


@persistent
def _note_opened(*_arguments: object) -> None:
    _count_again()
    session = session_of(bpy.context)
    find_objects(bpy.context, (*session.matches, *session.versions))


_HANDLERS = {
    "depsgraph_update_post": _count_again,
    "undo_post": _count_again,
    "redo_post": _count_again,
    "load_post": _note_opened,
}


def register() -> None:
    """Register the handlers."""
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    """Unregister the handlers."""
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).remove(handler)
