# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the session that the gallery shows: matches, the page, and the filters."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)

from .editor import area
from .editor.layout import LARGEST_PICTURE, SMALLEST_PICTURE
from .finding import is_here
from .labels import evidence_text
from .refining import search_again

__all__ = ["GalleryProperties", "register", "unregister"]

_SOURCES = (
    ("ANY", "Anywhere", "Matches of all files"),
    ("SCENE", "This Scene", "Only objects that are in the open scene"),
    ("FILES", "Other Files", "Only shapes that are not in the open scene"),
)

_RANKS = (
    ("BOTH", "Shape, then Kind", "The same shape first, then others of its kind"),
    ("SHAPE", "Same Shape", "Only by how likely they are the same shape"),
    ("KIND", "Same Kind", "Only by how likely they are of the same kind, such as another chair"),
)

_ANY = ("ANY", "Any", "")

# As `shapegoogle_core.library.origin.SHAPE_TYPES`, which registering must not import; a test compares them.
_TYPES = (
    _ANY,
    ("file", "File", "A mesh file that is one shape"),
    ("object", "Object", "A mesh object"),
    ("point cloud", "Point Cloud", "A point cloud"),
    ("curve", "Curve", "A curve with a surface"),
    ("text", "Text", "A text object"),
    ("surface", "Surface", "A surface object"),
    ("metaball", "Metaball", "A family of metaballs"),
    ("collection", "Collection", "A collection, appended as one"),
    ("instance", "Instance", "An object that shows a collection"),
    ("scatter", "Scatter", "An object with all that it instances"),
)

# As `shapegoogle_core.library.evidence.KINDS`; a test compares them.
_EVIDENCE = (
    _ANY,
    ("identical", "Identical", "The same surface at the same place"),
    ("moved", "Moved", "The same surface, moved or turned"),
    ("scaled", "Scaled", "The same surface at another size"),
    ("mirrored", "Mirrored", "Its mirror image"),
    ("re-meshed", "Re-Meshed", "The same surface with another mesh"),
    ("version", "Version", "The same shape, subdivided, smoothed or decimated"),
    ("re-posed", "Re-Posed", "The same shape, bent"),
    ("part of", "Part Of", "The query is a part of it"),
    ("contains", "Contains", "It is a part of the query"),
    ("similar", "Similar", "Alike, but none of the others"),
    ("same kind", "Same Kind", "Another shape of the same kind"),
    ("nothing in common", "Nothing in Common", "Another shape of another kind"),
)


def _draw_again(_session: Any, context: Any) -> None:
    area.redraw(context)


def _is_in_scene(match: Any) -> bool:
    return is_here(match)


def _evidence_text(match: Any) -> str:
    return evidence_text(match)


class SHAPEGOOGLE_PG_match(bpy.types.PropertyGroup):
    """One line of an answer."""

    shape_id: IntProperty()
    source: StringProperty(name="Source")
    object_name: StringProperty(name="Object")
    title: StringProperty(description="A name that says more than that of the object; may be empty")
    shape_type: StringProperty(name="Type", description="What the shape is in its file")
    tags: StringProperty(name="Tags", description="Separated by commas")
    catalog: StringProperty(name="Catalog", description="Path of the asset catalog")
    frame: StringProperty(name="Frame", description="Of the animation; empty for none")
    similarity: FloatProperty(name="Similarity")
    likeness: FloatProperty(
        name="Likeness", description="That it is of the same kind; -1: not known", default=-1
    )
    distance: FloatProperty(name="Distance")
    evidence: StringProperty(name="Evidence", description="Kind of the evidence; empty for none")
    share: FloatProperty(
        name="Share", description="Share of the surface that both have; -1: not known", default=-1.0
    )
    kind: StringProperty(name="Kind", description="The evidence in words", get=_evidence_text)
    size: FloatProperty(name="Size", description="Size relative to the query")
    vertex_count: IntProperty(name="Vertices")
    face_count: IntProperty(name="Faces")
    area: FloatProperty(name="Area", description="Of the surface, in the units of its file")
    placement_count: IntProperty(
        name="Objects", description="Number of objects of the file that show this shape", default=1
    )
    session_uid: IntProperty(description="Blender's number of the object, if it is in the open scene")
    version_count: IntProperty(name="Versions", description="Number of other versions of this shape")
    since: StringProperty(description="What has happened to it since the search; empty for nothing")
    in_scene: BoolProperty(
        name="In This Scene",
        description="Whether its object is in the open scene now",
        get=_is_in_scene,
    )


class GalleryProperties:
    """Part of the session: matches, and which of them are shown. Filters search again when they change."""

    matches: CollectionProperty(type=SHAPEGOOGLE_PG_match)
    active_match: IntProperty(name="Match", default=-1)
    opened: IntProperty(
        description="Index of the match whose versions are shown in place of the matches; -1: none",
        default=-1,
    )
    versions: CollectionProperty(type=SHAPEGOOGLE_PG_match)
    active_version: IntProperty(name="Version", default=-1)
    page_of_matches: IntProperty(description="Page to return to from the versions", min=0)
    page: IntProperty(name="Page", description="Page of the gallery, from 0", min=0)
    picture_size: IntProperty(
        name="Picture Size",
        description="Width of the pictures in the large gallery, in pixels",
        default=160,
        min=SMALLEST_PICTURE,
        max=LARGEST_PICTURE,
        subtype="PIXEL",
        update=_draw_again,
    )
    least_similarity: FloatProperty(
        name="Similarity",
        description=(
            "Lowest similarity of the matches; at 0.5 a match is as likely the same shape as a different one"
        ),
        default=0.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=search_again,
    )
    use_size: BoolProperty(
        name="Same Size",
        description="Find only matches of about the size of the query",
        default=False,
        update=search_again,
    )
    size_tolerance: FloatProperty(
        name="Tolerance",
        description="Largest difference between the size of a match and that of the query",
        default=10.0,
        min=0.1,
        max=100.0,
        subtype="PERCENTAGE",
        update=search_again,
    )
    source: EnumProperty(
        name="Source", description="Origin of the matches", items=_SOURCES, update=search_again
    )
    text: StringProperty(
        name="Text",
        description="Find only matches with this text in their name, tags, catalog or path",
        options={"TEXTEDIT_UPDATE"},
        update=search_again,
    )
    shape_type: EnumProperty(
        name="Type", description="What a shape is in its file", items=_TYPES, update=search_again
    )
    tag: StringProperty(
        name="Tag",
        description="Find only assets with this tag",
        options={"TEXTEDIT_UPDATE"},
        update=search_again,
    )
    catalog: StringProperty(
        name="Catalog",
        description="Find only assets in this catalog or below it, such as Props/Chairs",
        options={"TEXTEDIT_UPDATE"},
        update=search_again,
    )
    least_faces: IntProperty(
        name="Faces", description="Lowest number of faces", default=0, min=0, update=search_again
    )
    most_faces: IntProperty(
        name="To", description="Highest number of faces; 0: any", default=0, min=0, update=search_again
    )
    evidence: EnumProperty(
        name="Evidence",
        description="Kind of the evidence, found by comparing surfaces",
        items=_EVIDENCE,
        update=search_again,
    )
    rank: EnumProperty(
        name="Order", description="What comes first in the gallery", items=_RANKS, update=search_again
    )
    collapse: BoolProperty(
        name="Collapse Versions",
        description=(
            "Show only the best of all copies and versions of a shape, with the number of the others"
        ),
        default=True,
        update=search_again,
    )


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_match,))
