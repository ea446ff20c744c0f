# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the session that belong to the query: its examples, and its answer in words."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, StringProperty

from ..gallery.refining import search_again
from ..library.status_bar import redraw_status_bar

__all__ = ["SearchProperties", "examples_of", "register", "unregister"]

_SEVERAL = (
    ("JOINED", "One Shape", "Several selected objects are joined to one shape"),
    (
        "EXAMPLES",
        "Examples",
        "Each selected object is an example; find the shapes that all of them are like",
    ),
)


class SHAPEGOOGLE_PG_example(bpy.types.PropertyGroup):
    """A shape of a library as an example: to be found, or to be avoided."""

    library: StringProperty(
        description="Its library; in another library the same number belongs to another shape"
    )
    shape_id: IntProperty()
    source: StringProperty()
    shape_name: StringProperty(description="Its name in the library, which need not be that of its object")
    is_gone: BoolProperty(description="Whether it is not in its library any more")
    unlike: BoolProperty(name="Not Like This")


def _tell_status_bar(_session: Any, _context: Any) -> None:
    redraw_status_bar()


class SearchProperties:
    """Part of the session: the query."""

    # The status bar says so, and is drawn only when it is told to.
    searching: BoolProperty(name="Searching", update=_tell_status_bar)
    query: StringProperty(name="Query", description="Shape that was searched")
    several: EnumProperty(
        name="Several Objects", description="Meaning of several selected objects", items=_SEVERAL
    )
    examples: CollectionProperty(type=SHAPEGOOGLE_PG_example)
    show_examples: BoolProperty(name="Examples", description="Show the list of examples")
    active_example: IntProperty(name="Example")
    answer: StringProperty(name="Answer")
    library: StringProperty(name="Library", description="Library of the matches")
    asked: IntProperty(description="Number of examples to be found in the last query")
    top: IntProperty(
        name="Results",
        description="Number of matches to find",
        default=24,
        min=1,
        max=200,
        update=search_again,
    )


def examples_of(session: Any, library: str) -> list[tuple[int, Any]]:
    """Return the examples that are shapes of a library, each with its index.

    Parameters
    ----------
    session : SHAPEGOOGLE_PG_session
    library : str
        Its key, see `library.address.library_key`.

    Returns
    -------
    examples : list of (int, SHAPEGOOGLE_PG_example)
    """
    return [entry for entry in enumerate(session.examples) if entry[1].library == library]


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_example,))
