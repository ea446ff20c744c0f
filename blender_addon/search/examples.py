# SPDX-License-Identifier: GPL-3.0-or-later
"""Mark matches as examples for the next search: more like this, or not like this."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, IntProperty

from ..gallery.on_match import OnMatch, active_match
from ..library.address import library_key
from ..state import session_of
from ..translation import tr
from .properties import examples_of

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_OT_mark_example(OnMatch, bpy.types.Operator):
    """Make the chosen match an example."""

    bl_idname = "shape_google.mark_example"
    bl_label = "Mark as Example"

    unlike: BoolProperty(
        name="Not Like This", description="Shapes like this one come last", options={"SKIP_SAVE"}
    )

    @classmethod
    def description(cls, _context: Any, properties: Any) -> str:
        """Return the tooltip of either button."""
        if properties.unlike:
            return tr(
                "Not like this: in the next searches, shapes like this match come last. Press again to take "
                "it back"
            )
        return tr(
            "More like this: in the next searches, shapes that are also like this match come first. Press "
            "again to take it back"
        )

    def execute(self, context: Any) -> set[str]:
        """Add it to the list, or remove it if it is in the list already."""
        session = session_of(context)
        match = active_match(context)
        for index, example in enumerate(session.examples):
            if (example.library, example.shape_id) == (session.library, match.shape_id):
                if example.unlike == self.unlike:
                    session.examples.remove(index)
                else:
                    example.unlike = self.unlike
                return {"FINISHED"}
        example = session.examples.add()
        session.active_example = len(session.examples) - 1
        example.name = match.object_name or match.name
        example.library, example.shape_id, example.unlike = session.library, match.shape_id, self.unlike
        example.source, example.shape_name = match.source, match.name
        return {"FINISHED"}


def _has_examples(operator: Any, context: Any) -> bool:
    if not examples_of(session_of(context), library_key(context)):
        operator.poll_message_set(tr("There are no examples from this library"))
        return False
    return True


class SHAPEGOOGLE_OT_remove_example(bpy.types.Operator):
    """Remove an example from the list."""

    bl_idname = "shape_google.remove_example"
    bl_label = "Remove Example"
    bl_description = "Remove the chosen example from the list"
    bl_options = {"INTERNAL"}

    index: IntProperty(
        name="Example", description="Number in the list, from 0; -1: the chosen one", default=-1, min=-1
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there are examples."""
        return _has_examples(cls, context)

    def execute(self, context: Any) -> set[str]:
        """Remove it, and choose the one after it."""
        session = session_of(context)
        own = [index for index, _ in examples_of(session, library_key(context))]
        index = session.active_example if self.index < 0 else self.index
        if index not in own:
            return {"CANCELLED"}
        session.examples.remove(index)
        place = min(own.index(index), len(own) - 2)
        session.active_example = own[place] - (own[place] > index) if place >= 0 else 0
        return {"FINISHED"}


class SHAPEGOOGLE_OT_clear_examples(bpy.types.Operator):
    """Remove all examples from the list."""

    bl_idname = "shape_google.clear_examples"
    bl_label = "Clear Examples"
    bl_description = "Remove all examples from the list, so that the next query is the selection alone"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there are examples."""
        return _has_examples(cls, context)

    def execute(self, context: Any) -> set[str]:
        """Remove them."""
        session = session_of(context)
        for index, _ in reversed(examples_of(session, library_key(context))):
            session.examples.remove(index)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_mark_example, SHAPEGOOGLE_OT_remove_example, SHAPEGOOGLE_OT_clear_examples)
)
