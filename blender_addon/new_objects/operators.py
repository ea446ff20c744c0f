# SPDX-License-Identifier: GPL-3.0-or-later
"""*Check New Objects*: compare objects of the scene with the library, in the background."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import bpy

from .. import jobs, state
from ..gallery.labels import set_evidence
from ..library.address import library_address, library_missing
from ..library.open_file import open_source
from ..library.status_bar import redraw_status_bar
from ..search.answer import describe_match
from ..state import session_of
from ..translation import counted, error_text, tr
from .known import objects_to_check

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core import Mesh
    from shapegoogle_core.worker.checking import Near

__all__ = ["register", "unregister"]

T = TypeVar("T")

# Meshes handed to the worker at once: a search waits for no more than these.
MESHES_AT_ONCE = 2


class Check:
    """A check of objects, a few at a time.

    Parameters
    ----------
    context : bpy.types.Context
    items : sequence of bpy.types.Object
    """

    def __init__(self, context: Any, items: Sequence[Any]) -> None:
        groups: dict[tuple[int, int], list[int]] = {}
        for item in items:
            # With modifiers each object is a shape of its own.
            own = item.session_uid if item.modifiers else 0
            groups.setdefault((item.data.session_uid, own), []).append(item.session_uid)
        self._groups = list(groups.values())
        self._next = 0
        self._left_out = 0
        self.count = len(self._groups)
        self._library = library_address(context)
        self._least = session_of(context).check_similarity

    def read(self, context: Any) -> tuple[list[list[int]], list[Mesh]]:
        """Read the next few meshes; none after the last."""
        from shapegoogle_core import MeshError

        from ..scene.meshes import evaluated_mesh

        by_uid = {item.session_uid: item for item in context.view_layer.objects}
        groups: list[list[int]] = []
        meshes: list[Mesh] = []
        while self._next < self.count and len(meshes) < MESHES_AT_ONCE:
            group = self._groups[self._next]
            self._next += 1
            item = next((by_uid[uid] for uid in group if uid in by_uid), None)
            if item is None:  # deleted meanwhile
                continue
            try:
                mesh = evaluated_mesh(item)
            except MeshError:
                self._left_out += 1
                continue
            if mesh.is_point_cloud:
                self._left_out += 1
            else:
                groups.append(group)
                meshes.append(mesh)
        return groups, meshes

    def ask(self, meshes: Sequence[Mesh]) -> Future[list[Near | str | None]]:
        """Have the worker look for the shapes in the library."""
        from shapegoogle_core.worker.checking import check_meshes

        return jobs.worker().submit(check_meshes, self._library, meshes, open_source(), self._least)

    def take(self, context: Any, groups: Sequence[Sequence[int]], found: Sequence[Near | str | None]) -> None:
        """List what was found."""
        session = session_of(context)
        by_uid = {item.session_uid: item for item in context.view_layer.objects}
        for group, near in zip(groups, found, strict=True):
            item = next((by_uid[uid] for uid in group if uid in by_uid), None)
            if isinstance(near, str):
                self._left_out += 1
            elif near is not None and item is not None:
                line = session.new_objects.add()
                line.name, line.session_uid, line.object_count = item.name, item.session_uid, len(group)
                describe_match(line.match, near.match, near.signature.area)
                set_evidence(line.match, near.match.evidence)
                state.current().new_objects.signatures[item.session_uid] = near.signature
        session.check_progress = self._next / max(1, self.count)
        session.check_status = tr("{done:,} of {total:,} meshes checked").format(
            done=self._next, total=self.count
        )

    def note_checked(self) -> None:
        """Note that the objects are known; others that were added meanwhile are not."""
        known = state.current().new_objects.known
        known.update(uid for group in self._groups for uid in group)

    def summary(self, context: Any) -> str:
        """Say what was found."""
        if not self.count:
            return tr("There are no new meshes; choose Selected or Not Indexed to check others")
        count = len(session_of(context).new_objects)
        text = counted(
            "{count:,} of {total:,} meshes is in the library already, or nearly",
            "{count:,} of {total:,} meshes are in the library already, or nearly",
            count,
            total=self.count,
        )
        if not self._left_out:
            return text
        return tr("{text}; {others}").format(
            text=text,
            others=counted(
                "{count:,} mesh without faces was left out",
                "{count:,} meshes without faces were left out",
                self._left_out,
            ),
        )


class SHAPEGOOGLE_OT_check_new_objects(bpy.types.Operator):
    """Check whether new objects are in the library already."""

    bl_idname = "shape_google.check_new_objects"
    bl_label = "Check New Objects"
    bl_description = (
        "Compare imported and appended objects with the library, and list those that it already has, "
        "exactly or nearly. Nothing is changed"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a library and no check runs."""
        if session_of(context).checking:
            cls.poll_message_set(tr("Objects are already being checked"))
            return False
        missing = library_missing(context)
        if missing:
            cls.poll_message_set(missing)
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Check in the background; the window stays usable."""
        session, own = session_of(context), state.current().new_objects
        self._clear(context)
        session.checking, session.check_progress = True, 0.0
        session.check_status = tr("Looking for objects …")

        def wait_for(future: Future[T], then: Callable[[T], None]) -> None:
            own.task = future

            def done(result: T) -> None:
                if own.task is future:  # else cancelled, or another file
                    then(result)

            def failed(error: BaseException) -> None:
                if own.task is future:
                    own.task = None
                    session = session_of(bpy.context)
                    session.checking, session.check_status = False, error_text(error)
                    redraw_status_bar()

            jobs.watch(future, done, failed)

        def begin(indexed: frozenset[str]) -> None:
            session = session_of(bpy.context)
            go_on(Check(bpy.context, objects_to_check(bpy.context, session.check_which, indexed)))

        def go_on(check: Check) -> None:
            groups, meshes = check.read(bpy.context)
            if not meshes:
                _end(bpy.context, check)
                return

            def take(found: list[Near | str | None]) -> None:
                check.take(bpy.context, groups, found)
                redraw_status_bar()
                go_on(check)

            wait_for(check.ask(meshes), take)

        future = self._indexed(context)
        if future is None:
            begin(frozenset())
        else:
            wait_for(future, begin)
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """Check before returning."""
        from shapegoogle_core import ShapeGoogleError

        session = session_of(context)
        self._clear(context)
        try:
            future = self._indexed(context)
            indexed = frozenset() if future is None else future.result()
            check = Check(context, objects_to_check(context, session.check_which, indexed))
            while True:
                groups, meshes = check.read(context)
                if not meshes:
                    break
                check.take(context, groups, check.ask(meshes).result())
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        _end(context, check)
        self.report({"INFO"}, session.check_status)
        return {"FINISHED"}

    def _clear(self, context: Any) -> None:
        session_of(context).new_objects.clear()
        session_of(context).active_new_object = 0
        state.current().new_objects.signatures.clear()

    def _indexed(self, context: Any) -> Future[frozenset[str]] | None:
        """Ask for the objects of this file that are in the library, if that is needed."""
        from shapegoogle_core.worker.checking import names_of

        if session_of(context).check_which != "NOT_INDEXED":
            return None
        return jobs.worker().submit(names_of, library_address(context), open_source())


def _end(context: Any, check: Check) -> None:
    session = session_of(context)
    session.checking, session.check_status = False, check.summary(context)
    state.current().new_objects.task = None
    check.note_checked()
    redraw_status_bar()
    jobs.redraw()


class SHAPEGOOGLE_OT_cancel_check(bpy.types.Operator):
    """Stop checking."""

    bl_idname = "shape_google.cancel_check"
    bl_label = "Cancel Check"
    bl_description = "Stop checking; what was found so far stays listed"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that objects are being checked."""
        return bool(session_of(context).checking)

    def execute(self, context: Any) -> set[str]:
        """Stop it."""
        own, session = state.current().new_objects, session_of(context)
        if own.task is not None:
            own.task.cancel()
            own.task = None
        session.checking = False
        session.check_status = tr("Cancelled; what was found so far is listed")
        redraw_status_bar()
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_check_new_objects, SHAPEGOOGLE_OT_cancel_check)
)
