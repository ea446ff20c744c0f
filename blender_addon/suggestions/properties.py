# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the session that belong to suggestions."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, IntProperty, StringProperty

__all__ = ["SuggestionProperties", "register", "unregister"]


class SHAPEGOOGLE_PG_suggestion(bpy.types.PropertyGroup):
    """A tag or a catalog that shapes like an object have."""

    kind: StringProperty(description="tag or catalog")
    text: StringProperty(name="Text")
    confidence: FloatProperty(name="Confidence", description="Share of the nearest shapes that have it")
    relatives: StringProperty(name="Shapes", description="Nearest shapes that have it")
    use: BoolProperty(name="Write", description="Write it to the asset")


class SuggestionProperties:
    """Part of the session: suggestions for one object."""

    suggestions: CollectionProperty(type=SHAPEGOOGLE_PG_suggestion)
    suggested_for: IntProperty(description="Number of the object that they are for")
    suggesting: BoolProperty(name="Suggesting")


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_suggestion,))
