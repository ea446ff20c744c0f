# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done about an object that the library has already: keep it, or replace it by the library's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import bpy
from bpy.props import BoolProperty

from .. import jobs, state
from ..decisions.operators import submit
from ..decisions.properties import show_decisions
from ..gallery import placing
from ..gallery.labels import title
from ..library.open_file import open_source, shown_file
from ..replacing.operators import ReplaceProperties, Replaces
from ..state import session_of
from ..translation import error_text, tr

if TYPE_CHECKING:
    from shapegoogle_core.library.decisions.decision import Decision

__all__ = ["active_line", "register", "unregister"]


def active_line(context: Any) -> Any:
    """Return the chosen line of the list, or None."""
    session = session_of(context)
    lines, active = session.new_objects, session.active_new_object
    return lines[active] if 0 <= active < len(lines) else None


def _object_of(context: Any, line: Any) -> Any:
    """Return the object of a line, or None."""
    return next((item for item in context.view_layer.objects if item.session_uid == line.session_uid), None)


def _drop(context: Any, uid: int) -> None:
    """Take an object off the list."""
    session = session_of(context)
    for index, line in enumerate(session.new_objects):
        if line.session_uid == uid:
            session.new_objects.remove(index)
            break
    session.active_new_object = min(session.active_new_object, max(0, len(session.new_objects) - 1))
    state.current().new_objects.signatures.pop(uid, None)


class _OnLine:
    """Base of the operators on the chosen line, which `poll` has found."""

    @classmethod
    def poll(cls: Any, context: Any) -> bool:
        """Check that a line is chosen."""
        line = active_line(context)
        if line is None:
            cls.poll_message_set(tr("Check new objects and choose one first"))
            return False
        if _object_of(context, line) is None:
            cls.poll_message_set(tr("The object was deleted, or is not in this scene; check again"))
            return False
        return True


class SHAPEGOOGLE_OT_select_new_object(_OnLine, bpy.types.Operator):
    """Select the object."""

    bl_idname = "shape_google.select_new_object"
    bl_label = "Select"
    bl_description = "Select the object and nothing else"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    def execute(self, context: Any) -> set[str]:
        """Select it."""
        item = _object_of(context, active_line(context))
        placing.to_object_mode(context)
        placing.select_only(context, [item])
        return {"FINISHED"}


class SHAPEGOOGLE_OT_keep_new_object(_OnLine, bpy.types.Operator):
    """Keep the object."""

    bl_idname = "shape_google.keep_new_object"
    bl_label = "Dismiss"

    remember: BoolProperty(
        name="Remember",
        description="Remember in the library that both are kept",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def description(cls, _context: Any, properties: Any) -> str:
        """Return the tooltip of either button."""
        if properties.remember:
            return tr(
                "Keep the object beside the shape of the library, and remember that: no check lists the two "
                "again. The panel Decisions takes it back"
            )
        return tr("Take the object off the list; nothing is changed and nothing remembered")

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Keep it; the worker process remembers it."""
        line = active_line(context)
        uid, sentence = line.session_uid, self._sentence(line)
        if not self.remember:
            _drop(context, uid)
            return {"FINISHED"}

        def done(made: list[Decision]) -> None:
            _drop(bpy.context, uid)
            show_decisions(bpy.context, made)
            session_of(bpy.context).check_status = sentence

        def failed(error: BaseException) -> None:
            session_of(bpy.context).check_status = error_text(error)

        jobs.watch(self._submit(context, line), done, failed)
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """Keep it before returning."""
        from shapegoogle_core import ShapeGoogleError

        line = active_line(context)
        uid, sentence = line.session_uid, self._sentence(line)
        if self.remember:
            try:
                show_decisions(context, self._submit(context, line).result())
            except ShapeGoogleError as error:
                self.report({"ERROR"}, error_text(error))
                return {"CANCELLED"}
            self.report({"INFO"}, sentence)
        _drop(context, uid)
        return {"FINISHED"}

    def _sentence(self, line: Any) -> str:
        from shapegoogle_core.library.decisions.decision import told_apart

        match = line.match
        query, name = told_apart(
            (line.name, shown_file(open_source())), (title(match), shown_file(match.source))
        )
        return tr("Keep both {query} and {name}").format(query=query, name=name)

    def _submit(self, context: Any, line: Any) -> Any:
        from shapegoogle_core.worker.decisions import Outside

        signature = state.current().new_objects.signatures[line.session_uid]
        item = _object_of(context, line)
        own = Outside(signature, item.name, open_source())
        return submit(context, "KEEP_BOTH", [own], [line.match.shape_id])


class SHAPEGOOGLE_OT_replace_new_object(_OnLine, ReplaceProperties, Replaces, bpy.types.Operator):
    """Replace the object's mesh by that of the library."""

    bl_idname = "shape_google.replace_new_object"
    bl_label = "Replace"
    bl_description = (
        "Give the object, and all that share its mesh, the mesh of the library. Their names, transforms, "
        "modifiers, parents and children are kept, and so is their old mesh; the panel of the last operation "
        "has choices"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a line is chosen and nothing is being replaced."""
        if state.current().replacing.operator is not None:
            cls.poll_message_set(tr("Another mesh is being replaced"))
            return False
        return super().poll(context)

    def _match(self, context: Any) -> Any | None:
        return active_line(context).match

    def _targets(self, context: Any) -> list[Any]:
        item = _object_of(context, active_line(context))
        if item.modifiers:
            return [item]
        others = [
            other
            for other in context.view_layer.objects
            if other.data == item.data and other != item and not other.modifiers
        ]
        return [item, *others]


register, unregister = bpy.utils.register_classes_factory(
    (
        SHAPEGOOGLE_OT_select_new_object,
        SHAPEGOOGLE_OT_keep_new_object,
        SHAPEGOOGLE_OT_replace_new_object,
    )
)
