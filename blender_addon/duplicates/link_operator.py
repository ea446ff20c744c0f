# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator that lets the members of the chosen groups share one mesh."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Any, ClassVar

import bpy
from bpy.app.handlers import persistent

from .. import state
from ..time_slices import InSlices
from ..translation import counted, tr
from .members import is_in_object_mode, objects_by_name, objects_of

__all__ = ["register", "unregister"]

# Names in a report; more would not fit the status bar.
MOST_NAMES = 5


class SHAPEGOOGLE_OT_link_duplicates(InSlices, bpy.types.Operator):
    """Let the members of the chosen groups share the first one's mesh."""

    bl_idname = "shape_google.link_duplicates"
    bl_label = "Link Data"
    bl_description = (
        "Let the members of the chosen groups share the mesh of their first one. Nothing moves: matrices are "
        "corrected. Objects where this is not possible, such as with shape keys or an armature, are left "
        "unchanged and named"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    lost = False

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a group of the scene is chosen."""
        shown = context.window_manager.shape_google_duplicates
        if shown.running:
            cls.poll_message_set(tr("Wait until the search or the linking has ended, or cancel it"))
            return False
        if shown.found_in != "SCENE" or not any(group.chosen and group.linkable for group in shown.groups):
            cls.poll_message_set(tr("Choose at least one group of identical or scaled objects of this scene"))
            return False
        return is_in_object_mode(cls, context)

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Link them in time slices; the window shows the progress."""
        self._start(context)
        shown = context.window_manager.shape_google_duplicates
        shown.running = True
        state.current().duplicates.linking = self
        return self.begin(context, self._run.steps())

    def execute(self, context: Any) -> set[str]:
        """Link them before returning."""
        self._start(context)
        for _ in self._run.steps():
            pass
        return self.finish(context, cancelled=False)

    def modal(self, context: Any, event: Any) -> set[str]:
        """Go on, unless the objects are gone."""
        if self.lost:
            self.cancel(context)
            shown = context.window_manager.shape_google_duplicates
            shown.status = tr("Linking ended, since the scene was changed meanwhile; find duplicates again")
            self.report({"WARNING"}, shown.status)
            return {"CANCELLED"}
        return super().modal(context, event)

    def cancel(self, context: Any) -> None:
        """Stop the timer and free the buttons."""
        super().cancel(context)
        context.window_manager.shape_google_duplicates.running = False
        if state.is_registered():
            state.current().duplicates.linking = None

    def show_progress(self, context: Any) -> None:
        """Show the share that is done: comparing meshes and exchanging them count half each."""
        run, shown = self._run, context.window_manager.shape_google_duplicates
        shown.progress = (run.compared + run.done) / (2 * max(run.total, 1))
        exchanging = run.compared >= run.total
        count = run.done if exchanging else run.compared
        template = (
            tr("Linking: {done:,} of {count:,}") if exchanging else tr("Comparing: {done:,} of {count:,}")
        )
        shown.status = template.format(done=count, count=run.total)
        context.workspace.status_text_set(tr("{progress} (Esc: cancel)").format(progress=shown.status))

    def finish(self, context: Any, *, cancelled: bool) -> set[str]:
        """Report what was linked and what was not, and why."""
        shown = context.window_manager.shape_google_duplicates
        result = self._run.result
        reasons = _refusals([*self._gone, *result.refused])
        left = self._run.total - self._run.done
        template = (
            tr(
                "Cancelled: {linked:,} linked, {kept:,} left as they are, {left:,} not reached; Link Data "
                "goes on with them"
            )
            if cancelled
            else tr("{linked:,} linked, {kept:,} left as they are")
        )
        kept = len(result.refused) + len(self._gone)
        summary = template.format(linked=len(result.linked), kept=kept, left=left)
        # In one report with the reasons: Blender shows only the last one, and the panel only this text.
        shown.status = "; ".join((summary, *reasons))
        _refresh(context, shown, chosen=cancelled)
        self.report({"WARNING"} if reasons else {"INFO"}, shown.status)
        # Also after a cancel, so that what was linked is one step of undo.
        return {"FINISHED"} if result.linked else {"CANCELLED"}

    def _start(self, context: Any) -> None:
        from .linking import LinkRun

        shown = context.window_manager.shape_google_duplicates
        by_name = objects_by_name(context)
        groups: list[Sequence[Any]] = []
        self._gone: list[tuple[str, str]] = []
        for group in shown.groups:
            if group.chosen and group.linkable:
                objects = objects_of(context, group, by_name, "SCENE")
                if len(objects) > 1:
                    groups.append(objects)
                else:
                    reason = tr("its group is not there any more; find duplicates again")
                    self._gone.append((group.name, reason))
        self._run = LinkRun(context, groups)


def _refusals(refused: Sequence[tuple[str, str]]) -> list[str]:
    """Sentences about what was left as it is, one for each reason."""
    names = defaultdict(list)
    for name, reason in refused:
        names[reason].append(repr(name))
    lines = []
    for reason, which in names.items():
        listed = ", ".join(which[:MOST_NAMES])
        if len(which) > MOST_NAMES:
            listed = tr("{names} and {count} more").format(names=listed, count=len(which) - MOST_NAMES)
        lines.append(
            counted(
                "{names} was left as it is: {reason}",
                "{names} were left as they are: {reason}",
                len(which),
                names=listed,
                reason=reason,
            )
        )
    return lines


def _refresh(context: Any, shown: Any, *, chosen: bool) -> None:
    """Remove the groups whose members share one mesh now; the others stay chosen after a cancel only."""
    by_name = objects_by_name(context)
    for index in reversed(range(len(shown.groups))):
        group = shown.groups[index]
        if not group.linkable:
            continue
        objects = objects_of(context, group, by_name, "SCENE")
        if len({item.data for item in objects}) < 2:
            shown.groups.remove(index)
        else:
            group.chosen = group.chosen and chosen
    shown.index = min(shown.index, max(0, len(shown.groups) - 1))


class SHAPEGOOGLE_OT_choose_duplicates(bpy.types.Operator):
    """Choose all groups that can be linked."""

    bl_idname = "shape_google.choose_duplicates"
    bl_label = "Choose All Groups"
    bl_description = "Check the boxes of all groups that can be linked, or of none if all are checked"

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is such a group."""
        groups = context.window_manager.shape_google_duplicates.groups
        if not any(group.linkable for group in groups):
            cls.poll_message_set(tr("There is no group that can be linked"))
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        """Choose them."""
        groups = context.window_manager.shape_google_duplicates.groups
        linkable = [group for group in groups if group.linkable]
        chosen = not all(group.chosen for group in linkable)
        for group in linkable:
            group.chosen = chosen
        return {"FINISHED"}


@persistent
def _lose(*_arguments: object) -> None:
    """Undo, from another window, replaces all objects: the references to them are lost."""
    linking = state.current().duplicates.linking
    if linking is not None:
        linking.lost = True


_register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_link_duplicates, SHAPEGOOGLE_OT_choose_duplicates)
)


def register() -> None:
    """Register the operator."""
    _register()
    bpy.app.handlers.undo_pre.append(_lose)
    bpy.app.handlers.redo_pre.append(_lose)


def unregister() -> None:
    """Unregister the operator."""
    bpy.app.handlers.redo_pre.remove(_lose)
    bpy.app.handlers.undo_pre.remove(_lose)
    _unregister()
