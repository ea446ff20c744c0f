# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the session that belong to the query: its examples, and its answer in words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, StringProperty

__all__ = ["SearchProperties", "examples_of", "register", "unregister"]

_SEVERAL = (
    ("JOINED", "One Shape", "Several selected objects are joined to one shape"),
    (
        "EXAMPLES",
        "Examples",
        "Each selected object is an example of what is looked for: find what all are like",
    ),
)


class SHAPEGOOGLE_PG_example(bpy.types.PropertyGroup):
    """A shape of a library that is an example of what is looked for, or of what is not."""

    library: StringProperty(description="Its library: in another one its number is that of another shape")
    shape_id: IntProperty()
    unlike: BoolProperty(name="Not Like This")


class SearchProperties:
    """Part of the session: the query."""

    searching: BoolProperty(name="Searching")
    query: StringProperty(name="Query", description="What was looked for")
    several: EnumProperty(
        name="Several Objects", description="What several selected objects mean", items=_SEVERAL
    )
    examples: CollectionProperty(type=SHAPEGOOGLE_PG_example)
    answer: StringProperty(name="Answer")
    library: StringProperty(name="Library", description="Where the matches were found")
    asked: IntProperty(description="How many examples of what is looked for the last question had")
    top: IntProperty(
        name="Results", description="How many matches are looked for", default=24, min=1, max=200
    )


def examples_of(session: Any, library: Path) -> list[tuple[int, Any]]:
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


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_example,))
