# SPDX-License-Identifier: GPL-3.0-or-later
"""Find shapes like what is selected, and choose among the matches."""

from __future__ import annotations

import time
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import IntProperty

from .. import connections, jobs, scene
from ..library.scene_source import file_of, is_here
from ..preferences import preferences
from ..session import examples_of, session_of

if TYPE_CHECKING:
    from shapegoogle_core.service.requests import Answer

__all__ = ["register", "unregister"]

# The question that is being answered, so that it can be cancelled.
_asked: list[Future[Any]] = []
# The answer that is shown.
_shown: list[Answer] = []

# What stands below a match until its surface has been compared with the query's.
COMPARING = "Comparing …"
# Matches whose surfaces are compared in one go; a new question has to wait for it.
EXPLAINED_AT_ONCE = 6


class SHAPEGOOGLE_OT_find_similar(bpy.types.Operator):
    """Find shapes like the selected ones."""

    bl_idname = "shape_google.find_similar"
    bl_label = "Find Similar"
    bl_description = (
        "Find the shapes of the library that are most like the active object, in any pose, at any size. "
        "Several selected objects are one shape or several examples, as chosen below; in edit mode the "
        "selected faces are looked for"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """There is a shape and a library."""
        if session_of(context).searching:
            cls.poll_message_set("Searching already")
            return False
        active = context.active_object
        chosen = context.selected_objects if active is None else (*context.selected_objects, active)
        if not scene.shape_objects(chosen) and all(example.unlike for example in _examples(context)):
            cls.poll_message_set("Select a mesh or a point cloud")
            return False
        if not preferences(context).library_path().is_file():
            cls.poll_message_set("Index a library first")
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask in the worker process; the window stays usable."""
        future = self._ask(context)
        if future is None:
            return {"CANCELLED"}
        started = time.monotonic()

        def failed(error: BaseException) -> None:
            _asked.clear()
            session_of(bpy.context).searching = False
            _show_failure(bpy.context, str(error))

        def done(answer: Answer) -> None:
            _asked.clear()
            _show(bpy.context, answer, time.monotonic() - started)
            _explain_shown(answer)

        jobs.watch(future, done, failed)
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """Ask and wait for the answer."""
        from shapegoogle_core import ShapeGoogleError
        from shapegoogle_core.service.requests import explain

        started = time.monotonic()
        future = self._ask(context)
        if future is None:
            return {"CANCELLED"}
        try:
            answer = future.result()
            kinds = jobs.worker().submit(explain, answer.library, answer.signatures, answer.matches).result()
        except ShapeGoogleError as error:
            _show_failure(context, str(error))
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            _asked.clear()
            session_of(context).searching = False
        _show(context, answer, time.monotonic() - started)
        _show_kinds(context, kinds)
        self.report({"INFO"}, session_of(context).answer)
        return {"FINISHED"}

    def _ask(self, context: Any) -> Future[Answer] | None:
        from shapegoogle_core import MeshError
        from shapegoogle_core.service.requests import query

        session = session_of(context)
        examples = _examples(context)
        like = [example for example in examples if not example.unlike]
        unlike = [example for example in examples if example.unlike]
        try:
            meshes = scene.query_meshes(context, separate=session.several == "EXAMPLES")
        except MeshError as error:
            # With examples from the library nothing need be selected; in edit mode something was meant.
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
        _asked[:] = [future]
        session.searching = True
        session.query = scene.joined_name([shape.name for shape in (*meshes, *like)])
        if unlike:
            session.query += f", not like {scene.joined_name([example.name for example in unlike])}"
        session.answer = f"Looking for {session.query} …"
        return future


def _examples(context: Any) -> list[Any]:
    """Shapes of the present library that are examples of what is looked for, or of what is not."""
    return [example for _, example in examples_of(session_of(context), preferences(context).library_path())]


def _show(context: Any, answer: Answer, seconds: float) -> None:
    session = session_of(context)
    session.searching = False
    session.library, session.asked = str(answer.library), answer.examples
    session.matches.clear()
    _shown[:] = [answer]
    connections.forget_pictures()
    for match in answer.matches:
        line = session.matches.add()
        line.name = match.name
        line.object_name = match.object_name
        line.shape_id = match.shape_id
        line.source = file_of(match.source)
        line.similarity, line.distance = match.similarity, match.distance
        line.size = (match.area / answer.area) ** 0.5
        line.vertex_count = match.vertex_count
        line.kind = COMPARING
        line.in_scene = is_here(line.source, line.object_name)
        connections.keep_picture(match.shape_id, answer.thumbnails.get(match.shape_id))
    session.active_match = 0 if answer.matches else -1
    session.page = 0
    count = f"{len(answer.matches)} of {answer.shape_count:,} shapes"
    session.answer = f"{session.query}: the best {count}, {seconds:.1f} s"
    session.shape_count = answer.shape_count


def _show_kinds(context: Any, kinds: dict[int, str]) -> None:
    for line in session_of(context).matches:
        line.kind = kinds.get(line.shape_id, line.kind)


def _explain_shown(answer: Answer, first: int = 0) -> None:
    """Say what kind of match each is: after the answer, a few at a time, as long as it is the one shown."""
    from shapegoogle_core.service.requests import explain

    portion = answer.matches[first : first + EXPLAINED_AT_ONCE]
    if not portion or _shown != [answer]:
        return

    def done(kinds: dict[int, str]) -> None:
        if _shown == [answer]:
            _show_kinds(bpy.context, kinds)
            _explain_shown(answer, first + EXPLAINED_AT_ONCE)

    def failed(error: BaseException) -> None:
        if _shown == [answer]:
            rest = (match.shape_id for match in answer.matches[first:])
            _show_kinds(bpy.context, dict.fromkeys(rest, "Not compared"))
            session_of(bpy.context).answer += f"; surfaces could not be compared: {error}"

    jobs.watch(jobs.worker().submit(explain, answer.library, answer.signatures, portion), done, failed)


def _show_failure(context: Any, reason: str) -> None:
    session = session_of(context)
    session.matches.clear()
    _shown.clear()
    session.active_match = -1
    session.answer = reason


class SHAPEGOOGLE_OT_cancel_search(bpy.types.Operator):
    """Stop searching."""

    bl_idname = "shape_google.cancel_search"
    bl_label = "Cancel Search"
    bl_description = "Stop searching"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Something is searched."""
        return bool(session_of(context).searching)

    def execute(self, context: Any) -> set[str]:
        """Stop it."""
        while _asked:
            _asked.pop().cancel()
        session = session_of(context)
        session.searching = False
        session.answer = "Cancelled"
        return {"FINISHED"}


class SHAPEGOOGLE_OT_choose_match(bpy.types.Operator):
    """Choose a match."""

    bl_idname = "shape_google.choose_match"
    bl_label = "Choose Match"
    bl_options = {"INTERNAL"}

    index: IntProperty(options={"SKIP_SAVE"})

    @classmethod
    def description(cls, context: Any, properties: Any) -> str:
        """Return the tooltip of a match: all that has no room below its picture."""
        matches = session_of(context).matches
        if not 0 <= properties.index < len(matches):
            return "Choose this match"
        match = matches[properties.index]
        where = f"{match.object_name} in {match.source}" if match.object_name else match.source
        return (
            f"{where or match.name}\n{match.kind}. Similarity {match.similarity:.3f}, "
            f"distance {match.distance:.4f}, {match.vertex_count:,} vertices, size ×{match.size:.3g}"
        )

    def execute(self, context: Any) -> set[str]:
        """Choose it."""
        session = session_of(context)
        if not 0 <= self.index < len(session.matches):
            return {"CANCELLED"}
        session.active_match = self.index
        return {"FINISHED"}


class SHAPEGOOGLE_OT_turn_page(bpy.types.Operator):
    """Show other matches."""

    bl_idname = "shape_google.turn_page"
    bl_label = "Show More Matches"
    bl_description = "Show the next or the previous matches"
    bl_options = {"INTERNAL"}

    page: IntProperty(min=0, options={"SKIP_SAVE"})

    def execute(self, context: Any) -> set[str]:
        """Show them."""
        session_of(context).page = self.page
        return {"FINISHED"}


@bpy.app.handlers.persistent
def _look_again(*_arguments: Any) -> None:
    """Another file is open: other matches are in the scene."""
    for line in session_of(bpy.context).matches:
        line.in_scene = is_here(line.source, line.object_name)


_register, _unregister = bpy.utils.register_classes_factory(
    (
        SHAPEGOOGLE_OT_find_similar,
        SHAPEGOOGLE_OT_cancel_search,
        SHAPEGOOGLE_OT_choose_match,
        SHAPEGOOGLE_OT_turn_page,
    )
)


def register() -> None:
    """Make the operators known to Blender."""
    _register()
    bpy.app.handlers.load_post.append(_look_again)


def unregister() -> None:
    """Take them back, and forget the pictures."""
    bpy.app.handlers.load_post.remove(_look_again)
    _unregister()
    _shown.clear()
    connections.forget_pictures()
