# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the shapes of the library that are most like the selection."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs, state
from ..gallery.filters import conditions, size_factor
from ..library.address import library_address, library_key, library_missing
from ..library.present import when_it_goes
from ..library.status_bar import tell
from ..scene.reads_meshes import ReadsMeshes
from ..scene.selection import joined_name, query_objects, searched_objects
from ..state import session_of
from ..state.parts import Asked, SearchState
from ..translation import error_text, tr
from .answer import drop_answer, explain_matches, show_answer, show_evidence, show_matches
from .properties import examples_of

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core import Mesh, MeshError
    from shapegoogle_core.worker.requests import Answer

__all__ = ["refine", "refine_and_wait", "register", "search_with", "unregister"]


class SHAPEGOOGLE_OT_find_similar(ReadsMeshes, bpy.types.Operator):
    """Find shapes like the selected ones."""

    bl_idname = "shape_google.find_similar"
    bl_label = "Find Similar"
    bl_description = (
        "Find the shapes of the library that are most like the active object, in any pose, at any size. "
        "Several selected objects are one shape or several examples, as chosen under Examples; in edit mode "
        "the selected faces are the query"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a shape and a library."""
        if session_of(context).searching:
            cls.poll_message_set(tr("A search is already running"))
            return False
        active = context.active_object
        chosen = context.selected_objects if active is None else (*context.selected_objects, active)
        if not query_objects(chosen) and all(example.unlike for example in _examples(context)):
            cls.poll_message_set(tr("Select a mesh or a point cloud"))
            return False
        missing = library_missing(context)
        if missing:
            cls.poll_message_set(missing)
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Read the query in slices, and search in the worker process; the window stays usable."""
        from ..scene.query import query_steps

        self._searched = searched_objects(context)
        separate = session_of(context).several == "EXAMPLES"
        self._notes: list[str] = []
        return self.read_meshes(context, query_steps(context, separate=separate, notes=self._notes))

    def execute(self, context: Any) -> set[str]:
        """Search and wait for the answer."""
        from shapegoogle_core import MeshError, ShapeGoogleError
        from shapegoogle_core.worker.requests import explain

        from ..scene.query import query_meshes

        started = time.monotonic()
        self._searched, self._notes = searched_objects(context), []
        separate = session_of(context).several == "EXAMPLES"
        try:
            meshes = query_meshes(context, separate=separate, notes=self._notes)
        except MeshError as error:
            if self._refuse(context, error):
                return {"CANCELLED"}
            meshes = []
        future = self._ask(context, meshes)
        try:
            answer = future.result()
            explained = (
                jobs.worker().submit(explain, answer.library, answer.signatures, answer.matches).result()
            )
        except ShapeGoogleError as error:
            drop_answer(context, error_text(error))
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        finally:
            state.current().search.waiting = None
            session_of(context).searching = False
        show_answer(context, answer, time.monotonic() - started)
        show_evidence(context, explained)
        self.report({"INFO"}, session_of(context).answer)
        return {"FINISHED"}

    def begin(self, context: Any, steps: Iterator[object]) -> set[str]:
        """Go on reading in slices."""
        session, search = session_of(context), state.current().search
        search.reading, search.before = self, session.answer
        session.searching = True
        return super().begin(context, steps)

    def show_progress(self, context: Any) -> None:
        """Say that the query is being read; how much there is to read is known only in the end."""
        text = tr("Reading the query …")
        session_of(context).answer = text
        context.workspace.status_text_set(tr("{progress} (Esc: cancel)").format(progress=text))

    def cancel(self, context: Any) -> None:
        """Stop the timer and free the buttons."""
        super().cancel(context)
        session_of(context).searching = False
        if state.is_registered():
            search = state.current().search
            search.reading = None
            session_of(context).answer = search.before

    def take_meshes(self, context: Any, found: Sequence[Mesh]) -> set[str]:
        """Search with what was read."""
        _show_when_done(self._ask(context, found))
        return {"FINISHED"}

    def take_error(self, context: Any, error: MeshError) -> set[str]:
        """Search with the examples alone, if there are any."""
        return {"CANCELLED"} if self._refuse(context, error) else self.take_meshes(context, [])

    def take_cancelled(self, context: Any) -> set[str]:
        """Leave the answer that is shown."""
        session = session_of(context)
        if not session.matches:
            session.answer = tr("Cancelled")
        return {"CANCELLED"}

    def _refuse(self, context: Any, error: MeshError) -> bool:
        """Report that there is no query, unless there is one without the selection."""
        # With examples from the library the selection may be empty, but not in edit mode.
        if context.mode != "EDIT_MESH" and not all(example.unlike for example in _examples(context)):
            return False
        self.report({"ERROR"}, error_text(error))
        return True

    def _ask(self, context: Any, meshes: Sequence[Mesh]) -> Future[Answer]:
        examples = _examples(context)
        like = [example for example in examples if not example.unlike]
        unlike = [example for example in examples if example.unlike]
        state.current().search.unlike = [(example.shape_id, example.name) for example in unlike]
        title = joined_name([shape.name for shape in (*meshes, *like)])
        if unlike:
            others = joined_name([example.name for example in unlike])
            title = tr("{query}, not like {others}").format(query=title, others=others)
        stored = [(example.shape_id, example.name) for example in like]
        for note in self._notes:
            self.report({"WARNING"}, note)
        return _begin(context, meshes, stored, title, self._searched, tuple(self._notes))


def search_with(context: Any, shape: tuple[int, str]) -> None:
    """Search with a shape of the library, in the worker process.

    Parameters
    ----------
    context : bpy.types.Context
    shape : (int, str)
        Its id and name.
    """
    state.current().search.unlike = []
    _show_when_done(_begin(context, [], [shape], shape[1], frozenset()))


def _begin(
    context: Any,
    meshes: Sequence[Any],
    stored: Sequence[tuple[int, str]],
    title: str,
    searched: frozenset[int],
    notes: tuple[str, ...] = (),
) -> Future[Answer]:
    """Have the worker search, and say so."""
    session, search = session_of(context), state.current().search
    future = _submit(context, meshes, stored)
    search.waiting, search.searched, search.refine_at = future, searched, 0.0
    search.coming = [(mesh.name, 0) for mesh in meshes] + [(name, number) for number, name in stored]
    search.asking_with = Asked(tuple(meshes), tuple(shape_id for shape_id, _ in stored), notes)
    session.searching, session.query = True, title
    search.before = session.answer
    session.answer = tr("Searching for {name} …").format(name=title)
    return future


def _show_when_done(future: Future[Answer]) -> None:
    """Show the answer once it is there."""
    started = time.monotonic()

    def failed(error: BaseException) -> None:
        if state.current().search.waiting is future:
            drop_answer(bpy.context, error_text(error))
            tell(bpy.context, error_text(error))

    def done(answer: Answer) -> None:
        if state.current().search.waiting is future:  # else it was cancelled as it ended
            state.current().search.waiting = None
            show_answer(bpy.context, answer, time.monotonic() - started)
            _tell_where(bpy.context)
            explain_matches(answer)

    jobs.watch(future, done, failed)


def _tell_where(context: Any) -> None:
    """Say where the matches are if nothing shows them, as after a search from the Outliner."""
    if not jobs.shows_matches():
        text = tr("{answer}; the matches are in the sidebar of the 3D view (N), tab Shape Google")
        tell(context, text.format(answer=session_of(context).answer))


def _submit(context: Any, shapes: Sequence[Any], like: Sequence[tuple[int, str]] = ()) -> Future[Answer]:
    """Have the worker search the library, under the conditions of the filters."""
    from shapegoogle_core.worker.requests import query

    session = session_of(context)
    search = partial(
        query,
        families=session.collapse,
        where=conditions(session),
        rank=session.rank.lower(),
        size_factor=size_factor(session),
    )
    library = library_address(context)
    unlike = state.current().search.unlike
    return jobs.worker().submit(search, library, shapes, session.top, like, unlike)


def refine(context: Any) -> None:
    """Answer the present query again under the filters as they are now.

    Parameters
    ----------
    context : bpy.types.Context
    """
    search = state.current().search
    if search.answer is None or session_of(context).searching:
        return
    if search.waiting is not None:
        search.waiting.cancel()
    started = time.monotonic()
    future = search.waiting = _submit(context, search.answer.signatures)

    def done(answer: Answer) -> None:
        if state.current().search.waiting is future:
            state.current().search.waiting = None
            show_matches(bpy.context, answer, time.monotonic() - started)
            explain_matches(answer)

    def failed(error: BaseException) -> None:
        if state.current().search.waiting is future:
            state.current().search.waiting = None
            session_of(bpy.context).answer = error_text(error)

    jobs.watch(future, done, failed)


def refine_and_wait(context: Any) -> None:
    """Answer the present query again, as `refine` does, before returning.

    Parameters
    ----------
    context : bpy.types.Context

    Raises
    ------
    ShapeGoogleError
        If the library cannot be searched.
    """
    from shapegoogle_core.worker.requests import explain

    search = state.current().search
    if search.answer is None:
        return
    started = time.monotonic()
    answer = _submit(context, search.answer.signatures).result()
    explained = jobs.worker().submit(explain, answer.library, answer.signatures, answer.matches).result()
    show_matches(context, answer, time.monotonic() - started)
    show_evidence(context, explained)


def _examples(context: Any) -> list[Any]:
    """Examples that are shapes of the present library."""
    return [example for _, example in examples_of(session_of(context), library_key(context))]


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
        if search.reading is not None:
            search.reading.stopped = True  # it ends at its next tick
            return {"FINISHED"}
        if search.waiting is not None:
            search.waiting.cancel()
            search.waiting = None
        session = session_of(context)
        session.searching = False
        # What is shown is still the answer to the query before.
        session.answer = search.before if session.matches else tr("Cancelled")
        return {"FINISHED"}


_register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_find_similar, SHAPEGOOGLE_OT_cancel_search)
)


def register() -> None:
    """Register the operators."""
    _register()
    when_it_goes(drop_answer)


def unregister() -> None:
    """Unregister the operators and forget the answer."""
    _unregister()
    state.current().search = SearchState()
