# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the panel Duplicates, the groups found, and the progress of the search."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

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

from ..progress_bar import percentage
from ..translation import counted, marked
from .follow import remember

if TYPE_CHECKING:
    from .groups import Group

__all__ = ["KINDS", "register", "saving_text", "show_groups", "unregister"]

KINDS = {
    "IDENTICAL": (marked("Identical"), "LINKED"),
    "SCALED": (marked("Scaled"), "FULLSCREEN_ENTER"),
    "OTHER_DATA": (marked("Other Data"), "MATERIAL"),
    "SIMILAR": (marked("Similar"), "SHADERFX"),
    "COPIES": (marked("Copied Files"), "DUPLICATE"),
    "NOT_COMPARED": (marked("Not Compared"), "QUESTION"),
    "NOT_COMPARED_EQUAL_SIZE": (marked("Not Compared (Equal Size)"), "QUESTION"),
    "MOVED": (marked("Moved"), "EMPTY_ARROWS"),
    "MIRRORED": (marked("Mirrored"), "MOD_MIRROR"),
    "RE_MESHED": (marked("Re-meshed"), "MOD_REMESH"),
    "VERSION": (marked("Version"), "MOD_SUBSURF"),
    "RE_POSED": (marked("Re-posed"), "ARMATURE_DATA"),
    "PART_OF": (marked("Whole of It"), "SELECT_EXTEND"),
    "CONTAINS": (marked("Part of It"), "SELECT_INTERSECT"),
}
"""Name and icon of each kind of group."""


class SHAPEGOOGLE_PG_duplicate_member(bpy.types.PropertyGroup):
    """An object of a scene or a shape of a library; see `duplicates.Member`."""

    library: StringProperty()
    source: StringProperty()
    shape_id: IntProperty()
    scale: FloatProperty(default=1.0)
    similarity: FloatProperty(default=1.0)
    note: StringProperty()
    title: StringProperty()


class SHAPEGOOGLE_PG_duplicate_group(bpy.types.PropertyGroup):
    """A group of duplicates; see `duplicates.Group`."""

    chosen: BoolProperty(
        name="Chosen",
        description="Let the members of this group share one mesh with Link Data",
        default=False,
    )
    kind: StringProperty()
    meshes: IntProperty()
    # In megabytes, since large libraries save more bytes than 32 bits count.
    saved_megabytes: FloatProperty()
    saved_faces: IntProperty()
    linkable: BoolProperty()
    members: CollectionProperty(type=SHAPEGOOGLE_PG_duplicate_member)
    active_member: IntProperty(name="Member")


class SHAPEGOOGLE_PG_duplicates(bpy.types.PropertyGroup):
    """Settings and results of the search for duplicates; never saved in a file."""

    scope: EnumProperty(
        name="Scope",
        description="Where duplicates are searched",
        items=(
            ("SCENE", "Scene", "The mesh objects of this scene, before modifiers"),
            (
                "LIBRARY",
                "Library",
                "The shapes of the chosen library, which is not changed",
            ),
        ),
    )
    similar: BoolProperty(
        name="Similar Shapes",
        description=(
            "Also find shapes that are nearly the same, such as another pose or another mesh. "
            "In a scene this takes about half a second for each different mesh"
        ),
        default=True,
    )
    min_similarity: FloatProperty(
        name="Similarity",
        description="Lowest similarity to the first of a group",
        default=0.95,
        min=0.5,
        max=1.0,
        precision=3,
        subtype="FACTOR",
    )
    groups: CollectionProperty(type=SHAPEGOOGLE_PG_duplicate_group)
    index: IntProperty(name="Group")
    members: CollectionProperty(
        type=SHAPEGOOGLE_PG_duplicate_member,
        description="Always empty: the list shown while no group is chosen",
    )
    active_member: IntProperty(name="Member")
    found_in: StringProperty()
    status: StringProperty()
    running: BoolProperty()
    progress: FloatProperty()
    percent: percentage("progress")


def show_groups(
    shown: Any, groups: Sequence[Group], scope: str, *, add: bool = False, new: bool = True
) -> None:
    """Put groups into the list.

    Parameters
    ----------
    shown : SHAPEGOOGLE_PG_duplicates
    groups : sequence of Group
    scope : {"SCENE", "LIBRARY"}
        Where they were found.
    add : bool, optional
        Keep those that are in it.
    new : bool, optional
        Whether they were found just now, and are to be remembered.
    """
    if new:
        remember(groups if scope == "SCENE" else (), add=add)
    if not add:
        shown.groups.clear()
        shown.index = 0
    shown.found_in = scope
    for group in groups:
        entry = shown.groups.add()
        entry.name = group.members[0].title or group.members[0].name
        entry.kind = group.kind
        entry.meshes = group.meshes
        entry.saved_megabytes, entry.saved_faces = group.saved_bytes / 2**20, group.saved_faces
        entry.linkable = group.linkable
        for member in group.members:
            line = entry.members.add()
            line.name, line.library, line.source = member.name, member.library, member.source
            line.scale, line.similarity, line.note = member.scale, member.similarity, member.note
            line.shape_id, line.title = member.shape_id, member.title or member.name


def saving_text(group: Any) -> str:
    """Say how much a group takes more than one of its members would.

    Parameters
    ----------
    group : SHAPEGOOGLE_PG_duplicate_group

    Returns
    -------
    text : str
        Such as "2.5 MB" or "1,280 faces".
    """
    if group.saved_megabytes:
        return f"{group.saved_megabytes:,.1f} MB"
    return counted("{count:,} face", "{count:,} faces", group.saved_faces)


_register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_PG_duplicate_member, SHAPEGOOGLE_PG_duplicate_group, SHAPEGOOGLE_PG_duplicates)
)


def register() -> None:
    """Register the properties."""
    _register()
    bpy.types.WindowManager.shape_google_duplicates = PointerProperty(type=SHAPEGOOGLE_PG_duplicates)


def unregister() -> None:
    """Unregister the properties."""
    del bpy.types.WindowManager.shape_google_duplicates
    _unregister()
