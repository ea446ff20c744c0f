# SPDX-License-Identifier: GPL-3.0-or-later
"""*Replace With Match*: the selected objects get the mesh of the chosen match."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import bpy
from bpy.props import BoolProperty

from .. import jobs, state
from ..gallery import placing
from ..gallery.errors import PlacingError
from ..gallery.on_match import OnMatch, active_match
from ..library.model import model_source
from ..scene.selection import mesh_objects
from ..state.parts import ReplacingState
from ..translation import counted, error_text, tr

if TYPE_CHECKING:
    from concurrent.futures import Future

    import numpy as np
    from numpy.typing import NDArray

    from .incoming import Incoming

    Places = list[NDArray[np.float64] | None]

__all__ = ["Replaces", "register", "unregister"]

SECONDS_BETWEEN_LOOKS = 0.1
# Names in a report; more would not fit the status bar.
MOST_NAMES = 5


class Replaces:
    """Base of the operators that give objects the mesh of a match; `_match` and `_targets` say which."""

    # An operator that has not begun waits for nothing.
    stopped = False
    waits_for = ""

    def _match(self, context: Any) -> Any | None:
        """Return the match; None after a report."""
        raise NotImplementedError

    def _targets(self, context: Any) -> list[Any]:
        """Return the objects that are to get its mesh."""
        raise NotImplementedError

    def invoke(self: Any, context: Any, _event: Any) -> set[str]:
        """Find the new place in the worker process; the window stays usable."""
        if not self._begin(context):
            return {"CANCELLED"}
        if self._future is None:
            result: set[str] = self._finish(context)
            return result
        manager = context.window_manager
        self._timer = manager.event_timer_add(SECONDS_BETWEEN_LOOKS, window=context.window)
        manager.modal_handler_add(self)
        state.current().replacing.operator = self
        context.workspace.status_text_set(
            tr("Finding the place of {name} … (Esc: cancel)").format(name=self._incoming.name)
        )
        return {"RUNNING_MODAL"}

    def modal(self: Any, context: Any, event: Any) -> set[str]:
        """Wait for the worker."""
        if self.stopped or (event.type == "ESC" and event.value == "PRESS"):
            self.cancel(context)
            self.report({"INFO"}, tr("Nothing was replaced"))
            return {"CANCELLED"}
        # Objects are changed in object mode only: wait while the user edits or paints.
        if event.type != "TIMER" or not self._future.done() or context.mode != "OBJECT":
            return {"PASS_THROUGH"}
        self._end(context)
        result: set[str] = self._finish(context)
        return result

    def _end(self: Any, context: Any) -> None:
        if state.is_registered():
            state.current().replacing.operator = None
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        jobs.redraw()

    def cancel(self: Any, context: Any) -> None:
        """Stop waiting. Blender calls it too when it opens a file or ends, perhaps after unregistering."""
        self._future.cancel()
        self._end(context)
        self._drop()

    def execute(self: Any, context: Any) -> set[str]:
        """Replace before returning."""
        return self._finish(context) if self._begin(context) else {"CANCELLED"}

    def _begin(self: Any, context: Any) -> bool:
        """Bring the mesh in and ask the worker for its place; False after a report."""
        from shapegoogle_core import MeshError

        from .incoming import bring_mesh
        from .swapping import by_mesh, reason_against

        match = self._match(context)
        if match is None:
            return False
        placing.to_object_mode(context)
        targets = self._targets(context)
        before = {block.session_uid for block in bpy.data.user_map()}
        try:
            self._incoming: Incoming = bring_mesh(context, match)
        except PlacingError as error:
            self.report({"ERROR"}, error_text(error))
            return False
        self._came = {block.session_uid for block in bpy.data.user_map()} - before
        reasons = [(item, reason_against(item, self._incoming.mesh_uid)) for item in targets]
        self._refused = [(item.name, reason) for item, reason in reasons if reason]
        groups = list(by_mesh([item for item, reason in reasons if not reason]).values())
        # By number, since references do not survive an undo while the worker computes.
        self._groups = [[item.session_uid for item in items] for items in groups]
        self._future: Future[Places] | None = None
        if not groups:
            self._drop()
            self._report_refused({"ERROR"})
            return False
        if self.align:
            from shapegoogle_core.worker.laying import lay_meshes

            try:
                meshes = [self._old_mesh(items[0]) for items in groups]
            except MeshError as error:
                self._drop()
                self.report({"ERROR"}, error_text(error))
                return False
            self._future = jobs.worker().submit(
                lay_meshes, model_source(context), meshes, self._incoming.surface
            )
        return True

    def _old_mesh(self: Any, item: Any) -> Any:
        """Mesh whose place is taken: as it looks, or without the modifiers that stay on."""
        from ..scene.meshes import base_mesh, evaluated_mesh

        return base_mesh(item) if self.keep_modifiers else evaluated_mesh(item)

    def _drop(self: Any) -> None:
        """Remove what was brought in."""
        from .incoming import remove_unused

        remove_unused(self._came)

    def _finish(self: Any, context: Any) -> set[str]:
        from shapegoogle_core import ShapeGoogleError

        from .incoming import mesh_by_uid, remove_unused
        from .swapping import Choices, swap

        try:
            places = [None] * len(self._groups) if self._future is None else self._future.result()
        except ShapeGoogleError as error:
            self._drop()
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        by_uid = {item.session_uid: item for item in bpy.data.objects}
        data = mesh_by_uid(self._incoming.mesh_uid)
        if data is None or any(uid not in by_uid for uids in self._groups for uid in uids):
            self._drop()
            self.report(
                {"ERROR"},
                tr("An object or the match was removed meanwhile, so nothing was replaced; try again"),
            )
            return {"CANCELLED"}
        groups = [[by_uid[uid] for uid in uids] for uids in self._groups]
        choices = Choices(self.align, self.keep_materials, self.keep_modifiers, self.keep_mesh)
        done = swap(groups, self._incoming, data, places, choices)
        remove_unused(self._came)
        context.view_layer.update()
        self._report_done(done)
        return {"FINISHED"}

    def _report_done(self: Any, done: Any) -> None:
        if self._refused:
            self._report_refused({"WARNING"})
        parts = [
            counted(
                "{names} has the mesh of {match} now",
                "{count:,} objects have the mesh of {match} now",
                len(done.items),
                names=done.items[0].name,
                match=self._incoming.name,
            )
        ]
        if self.align and done.aligned < len(done.items):
            parts.append(tr("the shapes do not fit each other, so the mesh keeps its size"))
        if done.switched_off:
            parts.append(tr("modifiers are switched off: {names}").format(names=_listed(done.switched_off)))
        if done.kept_meshes:
            parts.append(tr("old meshes are kept: {names}").format(names=_listed(done.kept_meshes)))
        self.report({"INFO"}, "; ".join(parts))

    def _report_refused(self: Any, level: set[str]) -> None:
        if not self._refused:
            self.report(level, tr("Select the objects whose mesh is to be replaced"))
        for name, reason in self._refused[:MOST_NAMES]:
            self.report(level, tr("Left as it is: {name!r}, since {reason}").format(name=name, reason=reason))


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:MOST_NAMES]) + (" …" if len(names) > MOST_NAMES else "")


class ReplaceProperties:
    """Choices of the operators that replace."""

    align: BoolProperty(
        name="Align",
        description=(
            "Turn, move and scale the new mesh to where the old one was, if the two surfaces fit. The "
            "transform of the object is kept in any case"
        ),
        default=True,
    )
    keep_materials: BoolProperty(
        name="Keep Materials",
        description="Keep the materials of the object instead of those of the match",
    )
    keep_modifiers: BoolProperty(
        name="Keep Modifiers Enabled",
        description=(
            "Leave the modifiers of the object on; they act on the new mesh. Otherwise they are kept, but "
            "switched off"
        ),
    )
    keep_mesh: BoolProperty(
        name="Keep Old Mesh",
        description="Keep the old mesh in this file, with a fake user, if no object shows it any more",
        default=True,
    )


class SHAPEGOOGLE_OT_replace_with_match(ReplaceProperties, OnMatch, Replaces, bpy.types.Operator):
    """Replace the selected objects' mesh by that of the match."""

    bl_idname = "shape_google.replace_with_match"
    bl_label = "Replace With Match"
    bl_description = (
        "Give the selected objects the mesh of the match. Their names, transforms, modifiers, parents and "
        "children are kept, and so are their old meshes; the panel of the last operation has choices"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a match, and a mesh to be replaced."""
        if not super().poll(context):
            return False
        if state.current().replacing.operator is not None:
            cls.poll_message_set(tr("Another mesh is being replaced"))
            return False
        if not mesh_objects(context.selected_objects):
            cls.poll_message_set(tr("Select the objects whose mesh is to be replaced"))
            return False
        return True

    def _match(self, context: Any) -> Any | None:
        return active_match(context)

    def _targets(self, context: Any) -> list[Any]:
        active = context.view_layer.objects.active
        return sorted(mesh_objects(context.selected_objects), key=lambda item: item != active)


_register, _unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_OT_replace_with_match,))


def register() -> None:
    """Register the operator."""
    _register()


def unregister() -> None:
    """Unregister the operator; Blender ends one that waits without telling it."""
    _unregister()
    state.current().replacing = ReplacingState()
