# SPDX-License-Identifier: GPL-3.0-or-later
"""Show the versions of a match in the gallery: its copies, sizes and poses that the search has collapsed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import IntProperty

from .. import jobs, state
from ..gallery.on_match import shown_lines
from ..state import session_of
from ..translation import error_text, tr
from .answer import explain_matches, show_evidence, show_versions

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core.worker.requests import Answer

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_OT_show_versions(bpy.types.Operator):
    """Show the versions of a match, or the matches again."""

    bl_idname = "shape_google.show_versions"
    bl_label = "Show Versions"
    bl_description = (
        "Show the other versions of this shape: its copies, sizes and poses. Press again to return to all "
        "shapes"
    )
    bl_options = {"INTERNAL"}

    index: IntProperty(
        name="Match",
        description="Number of the match, from 0; -1: the chosen one",
        default=-1,
        min=-1,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a match."""
        session = session_of(context)
        lines, active = shown_lines(session)
        if session.opened < 0 and not (0 <= active < len(lines)):
            cls.poll_message_set(tr("Find similar shapes and choose a match first"))
            return False
        return not session.searching

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Show them as soon as the worker has listed them."""
        asked = self._ask(context)
        if asked is None:
            return {"FINISHED"}
        index, of, future = asked

        def done(answer: Answer) -> None:
            if state.current().search.answer is of:  # else there is another one now
                show_versions(bpy.context, answer, index)
                explain_matches(answer)

        def failed(error: BaseException) -> None:
            if state.current().search.answer is of:
                session_of(bpy.context).answer = error_text(error)

        jobs.watch(future, done, failed)
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """Show them before returning."""
        from shapegoogle_core import ShapeGoogleError
        from shapegoogle_core.worker.requests import explain

        asked = self._ask(context)
        if asked is None:
            return {"FINISHED"}
        index, _, future = asked
        try:
            answer = future.result()
            compared = jobs.worker().submit(explain, answer.library, answer.signatures, answer.matches)
            show_versions(context, answer, index)
            show_evidence(context, compared.result())
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _ask(self, context: Any) -> tuple[int, Answer, Future[Answer]] | None:
        """Have the worker list the versions; None if all shapes are shown again, or there are no versions."""
        from shapegoogle_core.worker.requests import versions

        session, search = session_of(context), state.current().search
        if session.opened >= 0:
            session.page, session.opened = session.page_of_matches, -1
            session.versions.clear()
            search.versions = None
            return None
        index = session.active_match if self.index < 0 else self.index
        answer = search.answer
        if answer is None or not 0 <= index < len(answer.matches) or not answer.matches[index].versions:
            return None
        session.active_match = index
        future = jobs.worker().submit(versions, answer.library, answer.signatures, answer.matches[index])
        return index, answer, future


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_OT_show_versions,))
