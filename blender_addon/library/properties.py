# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the session that the panel Library shows: progress, summary and errors of indexing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, IntProperty, StringProperty

from ..progress_bar import percentage

__all__ = ["IndexingProperties", "add_error", "register", "unregister"]


class SHAPEGOOGLE_PG_error(bpy.types.PropertyGroup):
    """A file that was not indexed, and the reason."""

    path: StringProperty(name="File")
    reason: StringProperty(name="Reason")
    details: StringProperty(name="Details", description="For a report of a fault of this program")


class SHAPEGOOGLE_PG_library_root(bpy.types.PropertyGroup):
    """A root of the library that is shown."""

    name: StringProperty(name="Root")
    path: StringProperty(name="Folder", description="Where it is; empty if that is not known")


class IndexingProperties:
    """Part of the session: indexing and training."""

    indexing: BoolProperty(name="Indexing")
    done: IntProperty()
    total: IntProperty()
    share: FloatProperty(description="Share of the work that is done, by time")
    percent: percentage("share")
    progress: StringProperty(name="Progress")
    brief_progress: StringProperty(name="Progress")
    summary: StringProperty(name="Summary")
    shape_count: IntProperty(name="Shapes")
    without_views: IntProperty(
        description="Number of shapes that an earlier version has described without views"
    )
    connection: StringProperty(description="What is wrong with the connection to a server; empty for nothing")
    roots: CollectionProperty(type=SHAPEGOOGLE_PG_library_root)
    errors: CollectionProperty(type=SHAPEGOOGLE_PG_error)
    active_error: IntProperty(name="Error")
    model: StringProperty(name="Model", description="Model of the library, or of a new one")
    # Seldom needed once there is a library, and as high as two rows of pictures: opened where there is none.
    show_sources: BoolProperty(name="Sources", description="Show what is indexed: folders and this scene")
    show_model: BoolProperty(name="Model", description="Show the model and its training")
    show_errors: BoolProperty(name="Not Indexed", description="Show what was not indexed, and why")
    training: StringProperty(name="Training")
    told: StringProperty(description="What the status bar says for a while")
    trained: StringProperty(name="Trained", description="How the last training ended")


def add_error(session: Any, path: str, reason: str, details: str = "") -> None:
    """Add an error to the list, once.

    Parameters
    ----------
    session : SHAPEGOOGLE_PG_session
    path : str
        The file.
    reason : str
        The error, and how to correct it.
    details : str, optional
        What those need who correct a fault of this program; it is copied, not shown.
    """
    if any(error.path == path and error.reason == reason for error in session.errors):
        return
    error = session.errors.add()
    error.name, error.path, error.reason, error.details = Path(path).name, path, reason, details


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_error, SHAPEGOOGLE_PG_library_root))
