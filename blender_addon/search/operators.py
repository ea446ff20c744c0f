# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the shapes of the library that are most like the selection."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs, state
from ..preferences import preferences
from ..scene.selection import joined_name, query_objects, searched_objects
from ..state import SearchState, session_of
from .answer import explain_matches, show_answer, show_evidence, show_failure
from .properties import examples_of

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core.service.requests import Answer

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_OT_find_similar(bpy.types.Operator):
    """Find shapes like the selected ones."""

    bl_idname = "shape_google.find_similar"
    bl_label = "Find Similar"
    bl_description = (
        "Find the shapes of the library that are most like the active object, in any pose, at any size. "
        "Several selected objects are one shape or several examples, as chosen below; in edit mode the "
        "selected faces are the query"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a shape and a library."""
        if session_of(context).searching:
            cls.poll_message_set("A search runs already")
            return False
        active = context.active_object
        chosen = context.selected_objects if active is None else (*context.selected_objects, active)
        if not query_objects(chosen) and all(example.unlike for example in _examples(context)):
            cls.poll_message_set("Select a mesh or a point cloud")
            return False
        if not preferences(context).library_path().is_file():
            cls.poll_message_set("Index a library first")
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Search in the worker process; the window stays usable."""
        future = self._ask(context)
        if future is None:
            return {"CANCELLED"}
        started = time.monotonic()

        def failed(error: BaseException) -> None:
            state.current().search.waiting = None
            session_of(bpy.context).searching = False
            show_failure(bpy.context, str(error))

        def done(answer: Answer) -> None:
            state.current().search.waiting = None
            show_answer(bpy.context, answer, time.monotonic() - started)
            explain_matches(answer)

        jobs.watch(future, done, failed)
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """Search and wait for the answer."""
        from shapegoogle_core import ShapeGoogleError
        from shapegoogle_core.service.requests import explain

        started = time.monotonic()
        future = self._ask(context)
        if future is None:
            return {"CANCELLED"}
        try:
            answer = future.result()
            explained = (
                jobs.worker().submit(explain, answer.library, answer.signatures, answer.matches).result()
            )
        except ShapeGoogleError as error:
            show_failure(context, str(error))
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            state.current().search.waiting = None
            session_of(context).searching = False
        show_answer(context, answer, time.monotonic() - started)
        show_evidence(context, explained)
        self.report({"INFO"}, session_of(context).answer)
        return {"FINISHED"}

    def _ask(self, context: Any) -> Future[Answer] | None:
        from shapegoogle_core import MeshError
        from shapegoogle_core.service.requests import query

        from ..scene.meshes import query_meshes

        session = session_of(context)
        examples = _examples(context)
        like = [example for example in examples if not example.unlike]
        unlike = [example for example in examples if example.unlike]
        try:
            meshes = query_meshes(context, separate=session.several == "EXAMPLES")
        except MeshError as error:
            # With examples from the library the selection may be empty, but not in edit mode.
            if not like or context.mode == "EDIT_MESH":
                self.report({"ERROR"}, str(error))
                return None
            meshes = []
        future = jobs.worker().submit(
            query,
            preferences(context).library_path(),
            meshes,
            session.top,
            [(example.shape_id, example.name) for example in like],
            [(example.shape_id, example.name) for example in unlike],
        )
        search = state.current().search
        search.waiting, search.searched = future, searched_objects(context)
        session.searching = True
        session.query = joined_name([shape.name for shape in (*meshes, *like)])
        if unlike:
            session.query += f", not like {joined_name([example.name for example in unlike])}"
        session.answer = f"Searching for {session.query} …"
        return future


def _examples(context: Any) -> list[Any]:
    """Examples that are shapes of the present library."""
    return [example for _, example in examples_of(session_of(context), preferences(context).library_path())]


class SHAPEGOOGLE_OT_cancel_search(bpy.types.Operator):
    """Stop searching."""

    bl_idname = "shape_google.cancel_search"
    bl_label = "Cancel Search"
    bl_description = "Stop searching"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a search runs."""
        return bool(session_of(context).searching)

    def execute(self, context: Any) -> set[str]:
        """Stop it."""
        search = state.current().search
        if search.waiting is not None:
            search.waiting.cancel()
            search.waiting = None
        session = session_of(context)
        session.searching = False
        session.answer = "Cancelled"
        return {"FINISHED"}


_register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_find_similar, SHAPEGOOGLE_OT_cancel_search)
)


def register() -> None:
    """Register the operators."""
    _register()


def unregister() -> None:
    """Unregister the operators and forget the answer."""
    _unregister()
    state.current().search = SearchState()
