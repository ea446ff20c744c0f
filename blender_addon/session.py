# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of this Blender session, on the window manager: results, progress, errors; no file keeps it.

Opening a file with its own windows brings a new window manager; the state is carried over to it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

__all__ = ["add_error", "examples_of", "register", "session_of", "shown_matches", "unregister"]

_SEVERAL = (
    ("JOINED", "One Shape", "Several selected objects are joined to one shape"),
    (
        "EXAMPLES",
        "Examples",
        "Each selected object is an example of what is looked for: find what all are like",
    ),
)

_SOURCES = (
    ("ANY", "Anywhere", "Matches of all files"),
    ("SCENE", "This Scene", "Only objects that are in the open scene"),
    ("FILES", "Other Files", "Only shapes that are not in the open scene"),
)


class SHAPEGOOGLE_PG_match(bpy.types.PropertyGroup):
    """One line of an answer."""

    shape_id: IntProperty()
    source: StringProperty(name="Source")
    object_name: StringProperty(name="Object")
    similarity: FloatProperty(name="Similarity")
    distance: FloatProperty(name="Distance")
    kind: StringProperty(name="Kind")
    size: FloatProperty(name="Size", description="How many times as large as the query")
    vertex_count: IntProperty(name="Vertices")
    in_scene: BoolProperty(name="In This Scene")


class SHAPEGOOGLE_PG_example(bpy.types.PropertyGroup):
    """A shape of a library that is an example of what is looked for, or of what is not."""

    library: StringProperty(description="Its library: in another one its number is that of another shape")
    shape_id: IntProperty()
    unlike: BoolProperty(name="Not Like This")


class SHAPEGOOGLE_PG_error(bpy.types.PropertyGroup):
    """A file that was not indexed, and why."""

    path: StringProperty(name="File")
    reason: StringProperty(name="Reason")


class SHAPEGOOGLE_PG_session(bpy.types.PropertyGroup):
    """State of this Blender session."""

    # -- indexing
    indexing: BoolProperty(name="Indexing")
    done: IntProperty()
    total: IntProperty()
    progress: StringProperty(name="Progress")
    summary: StringProperty(name="Summary")
    shape_count: IntProperty(name="Shapes")
    errors: CollectionProperty(type=SHAPEGOOGLE_PG_error)
    active_error: IntProperty(name="Error")
    training: StringProperty(name="Training")

    # -- search
    searching: BoolProperty(name="Searching")
    query: StringProperty(name="Query", description="What was looked for")
    several: EnumProperty(
        name="Several Objects", description="What several selected objects mean", items=_SEVERAL
    )
    examples: CollectionProperty(type=SHAPEGOOGLE_PG_example)
    answer: StringProperty(name="Answer")
    library: StringProperty(name="Library", description="Where the matches were found")
    asked: IntProperty(description="How many examples of what is looked for the last question had")
    matches: CollectionProperty(type=SHAPEGOOGLE_PG_match)
    active_match: IntProperty(name="Match", default=-1)
    page: IntProperty(name="Page", description="Which page of the gallery is shown, from 0", min=0)
    top: IntProperty(
        name="Results", description="How many matches are looked for", default=24, min=1, max=200
    )
    least_similarity: FloatProperty(
        name="Similarity",
        description="Least similarity of the matches shown; 0.5: as likely the same shape as another one",
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
    )
    use_size: BoolProperty(
        name="Same Size", description="Show only matches of about the size of the query", default=False
    )
    size_tolerance: FloatProperty(
        name="Tolerance",
        description="How far the size of a match may be from that of the query",
        default=10.0,
        min=0.1,
        max=100.0,
        subtype="PERCENTAGE",
    )
    source: EnumProperty(name="Source", description="Where matches may come from", items=_SOURCES)
    text: StringProperty(
        name="Text",
        description="Show only matches with this text in their name or path",
        options={"TEXTEDIT_UPDATE"},
    )
    collapse: BoolProperty(
        name="Collapse Duplicates", description="Show equal shapes only once", default=True
    )

    # -- transfer
    transfer_groups: BoolProperty(
        name="Vertex Groups", description="Transfer vertex groups with their weights", default=True
    )
    transfer_colors: BoolProperty(name="Colors", description="Transfer color attributes", default=True)
    transfer_uvs: BoolProperty(name="UVs", description="Transfer UV maps", default=True)
    transfer_replace: BoolProperty(
        name="Replace Existing",
        description="Overwrite vertex groups, color attributes and UV maps of the same name",
        default=False,
    )


def session_of(context: Any) -> SHAPEGOOGLE_PG_session:
    """Return the state of this Blender session."""
    session: SHAPEGOOGLE_PG_session = context.window_manager.shape_google
    return session


def examples_of(session: SHAPEGOOGLE_PG_session, library: Path) -> list[tuple[int, Any]]:
    """Return the examples that are shapes of a library, each with its index.

    Parameters
    ----------
    session : SHAPEGOOGLE_PG_session
    library : Path

    Returns
    -------
    examples : list of (int, SHAPEGOOGLE_PG_example)
    """
    return [entry for entry in enumerate(session.examples) if entry[1].library == str(library)]


def add_error(session: SHAPEGOOGLE_PG_session, path: str, reason: str) -> None:
    """Put an error into the list, once.

    Parameters
    ----------
    session : SHAPEGOOGLE_PG_session
    path : str
        The file.
    reason : str
        What is wrong and what to do.
    """
    if any(error.path == path and error.reason == reason for error in session.errors):
        return
    error = session.errors.add()
    error.name, error.path, error.reason = Path(path).name, path, reason


def shown_matches(session: SHAPEGOOGLE_PG_session) -> list[tuple[int, Any]]:
    """Return the matches that pass the filters, best first, each with its index.

    Parameters
    ----------
    session : SHAPEGOOGLE_PG_session

    Returns
    -------
    shown : list of (int, SHAPEGOOGLE_PG_match)
    """
    text = session.text.strip().lower()
    factor = 1 + session.size_tolerance / 100
    best: dict[tuple[float, int, float], int] = {}  # of each shape the place among those shown
    shown: list[tuple[int, Any]] = []
    for index, match in enumerate(session.matches):
        if match.similarity < session.least_similarity:
            continue
        if session.use_size and not 1 / factor <= match.size <= factor:
            continue
        if session.source != "ANY" and match.in_scene != (session.source == "SCENE"):
            continue
        if text and text not in f"{match.name}\n{match.source}".lower():
            continue
        # Equal distances to six digits and as many vertices: the same mesh, wherever it is.
        # Of several examples all copies have distance 0: the sizes of their poses tell them apart.
        size = round(match.size, 3) if session.asked > 1 else 0.0
        key = round(match.distance, 6), match.vertex_count, size
        if session.collapse and key in best:
            # The one that can be selected stands for its copies in files.
            if match.in_scene and not shown[best[key]][1].in_scene:
                shown[best[key]] = index, match
            continue
        best.setdefault(key, len(shown))
        shown.append((index, match))
    return shown


# What there was before a file was opened.
_kept: list[dict[str, Any]] = []


@bpy.app.handlers.persistent
def _keep(*_arguments: Any) -> None:
    _kept[:] = [_values(session_of(bpy.context))]


@bpy.app.handlers.persistent
def _bring_back(*_arguments: Any) -> None:
    while _kept:
        _assign(session_of(bpy.context), _kept.pop())


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


_register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_PG_match, SHAPEGOOGLE_PG_example, SHAPEGOOGLE_PG_error, SHAPEGOOGLE_PG_session)
)


def register() -> None:
    """Make the properties known to Blender."""
    _register()
    bpy.types.WindowManager.shape_google = PointerProperty(type=SHAPEGOOGLE_PG_session)
    bpy.app.handlers.load_pre.append(_keep)
    bpy.app.handlers.load_post.append(_bring_back)


def unregister() -> None:
    """Take them back; nothing goes on by the time the add-on is switched on again."""
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
    ):
        session.property_unset(name)
    del bpy.types.WindowManager.shape_google
    _unregister()
