# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfer vertex groups, colours and UVs of a match to the active object."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import bpy

from .. import jobs, state
from ..gallery import placing
from ..gallery.errors import PlacingError
from ..gallery.finding import object_of, sought
from ..gallery.labels import title
from ..gallery.on_match import OnMatch, active_match
from ..scene.selection import CARRIERS, mesh_objects, meshes_of
from ..state import session_of
from ..state.parts import TransferState
from ..translation import counted, error_text, tr

if TYPE_CHECKING:
    from concurrent.futures import Future

    from .carry_over import Source, Target, Transferred

__all__ = ["register", "unregister"]

SECONDS_BETWEEN_LOOKS = 0.1
# Below this mean confidence, or above this distortion, the two are hardly the same shape; and if another map
# costs less than this factor more, left and right may be exchanged.
POOR_CONFIDENCE, POOR_DISTORTION, CLOSE_CHOICE = 0.6, 0.1, 1.25


class SHAPEGOOGLE_OT_transfer_match(OnMatch, bpy.types.Operator):
    """Transfer the match's vertex groups, colours and UVs."""

    bl_idname = "shape_google.transfer_match"
    bl_label = "Transfer"
    bl_description = (
        "Transfer vertex groups, color attributes and UV maps of the match to the active object, which is "
        "the same shape in another pose or of another mesh. Both are used as they are before modifiers"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    waits_for = ""
    stopped = False

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a match, an object to transfer to, and something to transfer."""
        if not super().poll(context):
            return False
        if state.current().transfer.operator is not None:
            cls.poll_message_set(tr("A transfer is already running"))
            return False
        session = session_of(context)
        item = context.active_object
        if item is None or item.type not in ("MESH", *CARRIERS):
            cls.poll_message_set(tr("Select the object that you searched with"))
            return False
        if item.library is not None or (item.data is not None and item.data.library is not None):
            cls.poll_message_set(
                tr("The active object is linked from another file and cannot be changed here")
            )
            return False
        if not (session.transfer_groups or session.transfer_colors or session.transfer_uvs):
            cls.poll_message_set(tr("Choose what to transfer: vertex groups, colors or UVs"))
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Match the two shapes in a worker process; the window stays usable."""
        future = self._ask(context)
        if future is None:
            return {"CANCELLED"}
        self._future = future
        manager = context.window_manager
        self._timer = manager.event_timer_add(SECONDS_BETWEEN_LOOKS, window=context.window)
        manager.modal_handler_add(self)
        state.current().transfer.operator = self
        self._say(context, tr("Matching {name} …").format(name=self._target.mesh.name))
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        """Wait for the worker."""
        if self.stopped or (event.type == "ESC" and event.value == "PRESS"):
            self.cancel(context)
            self.report({"INFO"}, tr("Transfer cancelled"))
            return {"CANCELLED"}
        if event.type != "TIMER" or not self._future.done():
            return {"PASS_THROUGH"}
        if context.mode != "OBJECT":  # writing waits while the user edits, paints or sculpts
            self._say(context, tr("Waiting for object mode …"))
            return {"PASS_THROUGH"}
        self.cancel(context)
        return self._finish()

    def cancel(self, context: Any) -> None:
        """Stop waiting. Blender calls it too when it opens a file or ends, perhaps after unregistering."""
        self._future.cancel()
        if state.is_registered():
            state.current().transfer.operator = None
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        jobs.redraw()

    def _say(self, context: Any, what: str) -> None:
        """Show in the status bar and in the panel what the operator waits for."""
        if self.waits_for != what:
            self.waits_for = what
            context.workspace.status_text_set(tr("{progress} (Esc: cancel)").format(progress=what))
            jobs.redraw()

    def execute(self, context: Any) -> set[str]:
        """Match and write before returning."""
        future = self._ask(context)
        if future is None:
            return {"CANCELLED"}
        self._future = future
        return self._finish()

    def _ask(self, context: Any) -> Future[Any] | None:
        """Read both objects and hand them to the worker; None after a report."""
        from shapegoogle_core import MeshError
        from shapegoogle_core.correspondence import match_with_points

        from . import carry_over

        session = session_of(context)
        placing.to_object_mode(context)
        item = _target(context)
        if item is None:
            name = context.active_object.name
            text = tr("{name!r} has no visible mesh of this file; select the mesh to transfer to")
            self.report({"ERROR"}, text.format(name=name))
            return None
        # By number, since references do not survive an undo while the worker computes.
        self._item, self._replace = item.session_uid, session.transfer_replace
        try:
            self._target: Target = carry_over.read_target(item)
            self._source: Source = self._read_match(context, item)
        except (MeshError, PlacingError) as error:
            self.report({"ERROR"}, error_text(error))
            return None
        if not self._source.layers:
            text = tr("{name!r} has none of the data to transfer: vertex groups, colors and UVs")
            self.report({"ERROR"}, text.format(name=self._source.mesh.name))
            return None
        wanted, kept = carry_over.without_kept(item, self._source.layers, replace=self._replace)
        if not wanted:  # before the shapes are matched, which takes seconds
            self._report_kept(kept)
            return None
        return jobs.worker().submit(
            match_with_points, self._target.mesh, self._source.mesh, self._target.centers
        )

    def _read_match(self, context: Any, item: Any) -> Source:
        """Read the match, which is brought in for that and removed again if it is not in the scene."""
        from . import carry_over

        session = session_of(context)
        match = active_match(context)
        wanted = {
            "groups": session.transfer_groups,
            "colors": session.transfer_colors,
            "uvs": session.transfer_uvs,
        }
        here = object_of(context, match)
        if here == item:
            raise PlacingError(
                "{name!r} is the match itself; select the object to transfer to", name=item.name
            )
        if here is not None and here.type == "POINTCLOUD":
            raise PlacingError("{name!r} is a point cloud, which has nothing to transfer", name=match.name)
        if here is not None and here.type == "MESH":
            return carry_over.read_source(here, title(match), **wanted)
        selected, active = list(context.view_layer.objects.selected), context.view_layer.objects.active
        before = set(bpy.data.user_map())
        try:
            found = mesh_objects(placing.bring_in(context, match.source, sought(match)))
            if not found:
                raise PlacingError(
                    "{name!r} contains no mesh: a point cloud has nothing to transfer, and Index Library "
                    "reads files that have changed",
                    name=match.name,
                )
            if len(found) > 1 and not match.source.lower().endswith(".blend"):
                raise PlacingError(
                    "{name!r} is imported as {count} objects; append it, join them, and index the scene to "
                    "transfer from the whole",
                    name=match.name,
                    count=len(found),
                )
            context.view_layer.update()
            # Blender has numbered the object that was brought in: "Cow.002" is a name that nobody knows.
            return carry_over.read_source(found[0], title(match), **wanted)
        finally:
            placing.remove(context, [block for block in bpy.data.user_map() if block not in before])
            for each in context.view_layer.objects:
                each.select_set(each in selected)
            context.view_layer.objects.active = active

    def _finish(self) -> set[str]:
        from shapegoogle_core import ShapeGoogleError

        from . import carry_over

        try:
            match, centers = self._future.result()
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        item = next((each for each in bpy.data.objects if each.session_uid == self._item), None)
        count = len(self._target.mesh.vertices), len(self._target.corner_vertices)
        if item is None or not item.users_scene:  # other objects may still refer to one that was deleted
            text = tr("{name!r} was deleted meanwhile; nothing is transferred")
            self.report({"ERROR"}, text.format(name=self._target.mesh.name))
            return {"CANCELLED"}
        if (len(item.data.vertices), len(item.data.loops)) != count:
            text = tr("{name!r} has changed meanwhile; transfer again")
            self.report({"ERROR"}, text.format(name=self._target.mesh.name))
            return {"CANCELLED"}
        done = carry_over.transfer(item, self._source, self._target, match, centers, replace=self._replace)
        if done.kept:
            self._report_kept(done.kept)
        if done.refused:
            text = tr("No room for the UV maps {names}; remove others first")
            self.report({"WARNING"}, text.format(names=_listed(done.refused)))
        if not done.count:
            return {"CANCELLED"}
        self._report(item, done, match)
        return {"FINISHED"}

    def _report_kept(self, names: list[str]) -> None:
        text = tr(
            "Kept unchanged: {names}; enable Replace Existing to overwrite them, and unlock locked groups"
        )
        self.report({"WARNING"}, text.format(names=_listed(names)))

    def _report(self, item: Any, done: Transferred, match: Any) -> None:
        confidence = float(match.confidence[match.face >= 0].mean())
        what = []
        if done.groups:
            what.append(counted("{count} vertex group", "{count} vertex groups", len(done.groups)))
        if done.colors:
            what.append(counted("{count} color attribute", "{count} color attributes", len(done.colors)))
        if done.uvs:
            what.append(counted("{count} UV map", "{count} UV maps", len(done.uvs)))
        text = tr(
            "Transferred {layers} from {source!r} to {target!r}, mean confidence {confidence:.2f}"
        ).format(
            layers=", ".join(what),
            source=self._source.mesh.name,
            target=item.name,
            confidence=confidence,
        )
        if confidence < POOR_CONFIDENCE or match.distortion > POOR_DISTORTION:
            warning = tr("{summary}: a poor fit, possibly not the same shape; check the result")
        elif match.runner_up < CLOSE_CHOICE:
            warning = tr(
                "{summary}; two alignments fit almost equally well: check whether left and right are "
                "exchanged"
            )
        else:
            self.report({"INFO"}, text)
            return
        self.report({"WARNING"}, warning.format(summary=text))


def _target(context: Any) -> Any | None:
    """Return the active object; of the meshes of a rig or the like, the one with the largest surface.

    A map between two surfaces takes one surface each: of a character that is the body, without its eyes.
    """
    meshes = [
        mesh
        for mesh in meshes_of(context.active_object, context)
        if mesh.library is None and mesh.data.library is None
    ]
    return max(meshes, key=_area, default=None)


def _area(item: Any) -> float:
    scale = abs(item.matrix_world.determinant()) ** (2 / 3)
    return float(scale * sum(polygon.area for polygon in item.data.polygons))


def _listed(names: list[str]) -> str:
    shown = ", ".join(repr(name) for name in names[:5])
    if len(names) <= 5:
        return shown
    return tr("{names} and {count} more").format(names=shown, count=len(names) - 5)


class SHAPEGOOGLE_OT_cancel_transfer(bpy.types.Operator):
    """Stop the transfer."""

    bl_idname = "shape_google.cancel_transfer"
    bl_label = "Cancel Transfer"
    bl_description = "Stop the transfer; nothing has been changed yet"

    @classmethod
    def poll(cls, _context: Any) -> bool:
        """Check that a transfer runs."""
        return state.current().transfer.operator is not None

    def execute(self, _context: Any) -> set[str]:
        """Stop it."""
        running = state.current().transfer.operator
        if running is not None:
            running.stopped = True  # it ends at its next tick
        return {"FINISHED"}


register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_transfer_match, SHAPEGOOGLE_OT_cancel_transfer)
)


def unregister() -> None:
    """Unregister the operators; Blender ends a running transfer without telling it."""
    _unregister()
    state.current().transfer = TransferState()
