# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the session that the panel New Objects shows."""

from __future__ import annotations

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

from ..gallery.properties import SHAPEGOOGLE_PG_match
from ..progress_bar import percentage

__all__ = ["NewObjectsProperties", "register", "unregister"]

_WHICH = (
    (
        "NEW",
        "New",
        "Meshes that were added to the scene since the last check, or since the file was opened",
    ),
    ("SELECTED", "Selected", "The selected meshes"),
    (
        "NOT_INDEXED",
        "Not Indexed",
        "All meshes of the scene that are not in the library as objects of this file",
    ),
)


class SHAPEGOOGLE_PG_new_object(bpy.types.PropertyGroup):
    """An object of the scene, and the shape of the library that it nearly is."""

    session_uid: IntProperty(description="Blender's number of the object")
    object_count: IntProperty(
        name="Objects", description="Number of the checked objects that share its mesh", default=1
    )
    match: PointerProperty(type=SHAPEGOOGLE_PG_match)


class NewObjectsProperties:
    """Part of the session: the check of new objects."""

    check_which: EnumProperty(name="Check", description="Objects that are checked", items=_WHICH)
    check_similarity: FloatProperty(
        name="Similarity",
        description=(
            "Lowest similarity of a shape that is neither a copy nor a version nor another pose of the object"
        ),
        default=0.95,
        min=0.5,
        max=1.0,
        precision=3,
        subtype="FACTOR",
    )
    new_objects: CollectionProperty(type=SHAPEGOOGLE_PG_new_object)
    active_new_object: IntProperty(name="Object")
    checking: BoolProperty(name="Checking")
    check_progress: FloatProperty(name="Progress")
    check_percent: percentage("check_progress")
    check_status: StringProperty(name="Status")


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_new_object,))
