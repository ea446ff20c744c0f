# SPDX-License-Identifier: GPL-3.0-or-later
"""State of this Blender session on the window manager: results, progress, errors; it is not saved in files.

Each feature describes its own part in its ``properties.py``. Opening a file with its own windows brings a new
window manager; the state is carried over to it.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import PointerProperty

from .decisions.properties import DecisionProperties
from .gallery.properties import GalleryProperties
from .library.properties import IndexingProperties
from .new_objects.properties import NewObjectsProperties
from .search.properties import SearchProperties
from .state import current, session_of
from .suggestions.properties import SuggestionProperties
from .transfer.properties import TransferProperties

__all__ = ["SHAPEGOOGLE_PG_session", "register", "unregister"]


class SHAPEGOOGLE_PG_session(
    IndexingProperties,
    SearchProperties,
    GalleryProperties,
    TransferProperties,
    SuggestionProperties,
    DecisionProperties,
    NewObjectsProperties,
    bpy.types.PropertyGroup,
):
    """State of this Blender session."""


@bpy.app.handlers.persistent
def _keep(*_arguments: Any) -> None:
    current().kept_session = _values(session_of(bpy.context))


@bpy.app.handlers.persistent
def _bring_back(*_arguments: Any) -> None:
    kept = current().kept_session
    if kept is not None:
        _assign(session_of(bpy.context), kept)
        current().kept_session = None


def _values(group: Any) -> dict[str, Any]:
    """Read all that is set in a property group, collections included."""
    values: dict[str, Any] = {}
    for entry in group.bl_rna.properties:
        name = entry.identifier
        if entry.type == "COLLECTION":
            values[name] = [_values(item) for item in getattr(group, name)]
        elif not entry.is_readonly:
            values[name] = getattr(group, name)
    return values


def _assign(group: Any, values: dict[str, Any]) -> None:
    for name, value in values.items():
        if isinstance(value, list):
            collection = getattr(group, name)
            collection.clear()
            for item in value:
                _assign(collection.add(), item)
        else:
            setattr(group, name, value)


_register, _unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_session,))


def register() -> None:
    """Register the properties, and the handlers that carry them over to another file."""
    _register()
    bpy.types.WindowManager.shape_google = PointerProperty(type=SHAPEGOOGLE_PG_session)
    bpy.app.handlers.load_pre.append(_keep)
    # First, since the handlers of the features read the session.
    bpy.app.handlers.load_post.insert(0, _bring_back)


def unregister() -> None:
    """Unregister the properties; those of work that ends now are reset."""
    bpy.app.handlers.load_post.remove(_bring_back)
    bpy.app.handlers.load_pre.remove(_keep)
    session = session_of(bpy.context)
    for name in (
        "indexing",
        "progress",
        "searching",
        "training",
        "matches",
        "examples",
        "answer",
        "active_match",
        "versions",
        "opened",
        "checking",
        "check_status",
        "new_objects",
        "decisions",
        "decided",
    ):
        session.property_unset(name)
    del bpy.types.WindowManager.shape_google
    _unregister()
