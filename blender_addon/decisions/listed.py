# SPDX-License-Identifier: GPL-3.0-or-later
"""List the decisions of the library, and take them back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import IntProperty

from .. import jobs
from ..library.address import library_address, library_missing
from ..library.present import when_it_changes, when_it_goes
from ..search.operators import refine, refine_and_wait
from ..state import session_of
from ..translation import counted, error_text, tr
from .properties import show_decisions

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core.library.decisions.decision import Decision

__all__ = ["register", "unregister"]


def _list_again(context: Any) -> None:
    """List the decisions as they are now; other programs decide too."""
    from shapegoogle_core.worker.decisions import decisions

    address = library_address(context)

    def done(made: list[Decision]) -> None:
        if library_address(bpy.context) == address:
            show_decisions(bpy.context, made)

    def failed(error: BaseException) -> None:
        session_of(bpy.context).decided = error_text(error)

    jobs.watch(jobs.worker().submit(decisions, address), done, failed)


def _forget(context: Any, _reason: str) -> None:
    session = session_of(context)
    session.decisions.clear()
    session.decided = ""


class SHAPEGOOGLE_OT_list_decisions(bpy.types.Operator):
    """List the decisions."""

    bl_idname = "shape_google.list_decisions"
    bl_label = "List Decisions"
    bl_description = "List what was decided about shapes of the library, the latest decision first"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a library."""
        missing = library_missing(context)
        if missing:
            cls.poll_message_set(missing)
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """List them once the worker has read them."""
        _list_again(context)
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """List them before returning."""
        from shapegoogle_core import ShapeGoogleError
        from shapegoogle_core.worker.decisions import decisions

        try:
            made = jobs.worker().submit(decisions, library_address(context)).result()
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        show_decisions(context, made)
        return {"FINISHED"}


class SHAPEGOOGLE_OT_undo_decisions(bpy.types.Operator):
    """Take decisions back."""

    bl_idname = "shape_google.undo_decisions"
    bl_label = "Undo Decisions"
    bl_description = (
        "Undo the chosen decisions, or the active one if none is chosen. Everyone who uses the library "
        "then finds again what they had left out"
    )

    index: IntProperty(
        name="Decision",
        description="Number of a decision in the list, from 0; -1: the chosen ones",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there are decisions."""
        if not len(session_of(context).decisions):
            cls.poll_message_set(tr("Nothing was decided yet"))
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Take them back in the worker process."""
        numbers, future = self._ask(context)
        if future is None:
            return {"CANCELLED"}

        def done(made: list[Decision]) -> None:
            _show_rest(bpy.context, numbers, made)
            refine(bpy.context)

        def failed(error: BaseException) -> None:
            session_of(bpy.context).decided = error_text(error)

        jobs.watch(future, done, failed)
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """Take them back before returning."""
        from shapegoogle_core import ShapeGoogleError

        numbers, future = self._ask(context)
        if future is None:
            return {"CANCELLED"}
        try:
            _show_rest(context, numbers, future.result())
            refine_and_wait(context)
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        self.report({"INFO"}, session_of(context).decided)
        return {"FINISHED"}

    def _ask(self, context: Any) -> tuple[list[int], Future[list[Decision]] | None]:
        from shapegoogle_core.worker.decisions import undo

        session = session_of(context)
        lines = list(session.decisions)
        index = session.active_decision if self.index < 0 else self.index
        chosen = [line.number for line in lines if line.chosen] if self.index < 0 else []
        if not chosen and 0 <= index < len(lines):
            chosen = [lines[index].number]
        if not chosen:
            return [], None
        return chosen, jobs.worker().submit(undo, library_address(context), chosen)


def _show_rest(context: Any, numbers: Sequence[int], made: Sequence[Decision]) -> None:
    """Show the decisions that are left, and say how many were taken back."""
    session = session_of(context)
    titles = [line.name for line in session.decisions if line.number in numbers]
    show_decisions(context, made)
    if len(titles) == 1:
        session.decided = tr("Taken back: {title}").format(title=titles[0])
    else:
        session.decided = counted(
            "{count:,} decision taken back", "{count:,} decisions taken back", len(titles)
        )


_register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_list_decisions, SHAPEGOOGLE_OT_undo_decisions)
)


def register() -> None:
    """Register the operators, and follow the library."""
    _register()
    when_it_changes(_list_again)
    when_it_goes(_forget)
