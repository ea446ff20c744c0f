# SPDX-License-Identifier: GPL-3.0-or-later
"""Find groups of duplicates and select them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import bpy
from bpy.app.handlers import persistent
from bpy.props import IntProperty

from .. import jobs, state
from ..library.address import library_address, library_missing
from ..library.model import model_source
from ..library.present import when_it_goes
from ..time_slices import InSlices
from ..translation import counted, error_text, tr
from .background import BackgroundSearch, LibrarySearch, SimilarSearch, summary
from .members import is_in_object_mode, objects_by_name, objects_of
from .properties import show_groups

if TYPE_CHECKING:
    from shapegoogle_core import Mesh

    from .groups import SceneShapes, Solid

__all__ = ["register", "unregister"]


def _begin(search: BackgroundSearch) -> None:
    state.current().duplicates.search = search


def _cancel_running() -> None:
    running = state.current().duplicates.search
    if running is not None:
        running.cancel()
        state.current().duplicates.search = None
    linking = state.current().duplicates.linking
    if linking is not None:
        linking.stopped = True  # it ends at its next tick
    collecting = state.current().duplicates.collecting
    if collecting is not None:
        collecting.stopped = True


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:5]) + (" …" if len(names) > 5 else "")


class SHAPEGOOGLE_OT_find_duplicates(InSlices, bpy.types.Operator):
    """Find groups of the same and of similar shapes; nothing is changed."""

    bl_idname = "shape_google.find_duplicates"
    bl_label = "Find Duplicates"
    bl_description = (
        "List groups of the same and of similar shapes, in the scene or the library. Nothing is changed. "
        "Objects that share a mesh are no duplicates, nor are mirrored ones"
    )
    bl_options: ClassVar = {"REGISTER"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is something to search and no search runs."""
        shown = context.window_manager.shape_google_duplicates
        if shown.running:
            cls.poll_message_set(tr("A search for duplicates is running"))
            return False
        missing = library_missing(context) if shown.scope == "LIBRARY" else ""
        if missing:
            cls.poll_message_set(missing)
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Compare the meshes of the scene in slices; the rest goes on in the background."""
        shown = context.window_manager.shape_google_duplicates
        _cancel_running()
        if shown.scope == "LIBRARY":
            from shapegoogle_core.worker.requests import library_duplicates

            library = LibrarySearch()
            _begin(library)
            library.start(tr("Looking through the library …"))
            library.submit(library.take, library_duplicates, library_address(context), shown.min_similarity)
            return {"FINISHED"}
        from .groups import Collecting

        self._collecting = Collecting(context, context.scene.objects)
        self._solids: list[tuple[Solid, Mesh]] = []
        shown.running, shown.progress = True, 0.0
        state.current().duplicates.collecting = self
        return self.begin(context, self._steps_of(similar=shown.similar))

    def _steps_of(self, *, similar: bool) -> Iterator[bool]:
        """Compare the meshes with each other; read those to describe."""
        from .congruence import LARGE
        from .groups import solid_shapes

        yield from self._collecting.steps()
        if similar:
            for solid in solid_shapes(self._collecting.found):
                self._solids.append(solid)
                yield solid[0].faces >= LARGE

    def show_progress(self, context: Any) -> None:
        """Show the share of the meshes that have been compared."""
        shown, run = context.window_manager.shape_google_duplicates, self._collecting
        shown.progress = run.compared / max(run.total, 1)
        shown.status = tr("Comparing meshes: {done:,} of {total:,}").format(
            done=run.compared, total=run.total
        )
        context.workspace.status_text_set(tr("{progress} (Esc: cancel)").format(progress=shown.status))

    def cancel(self, context: Any) -> None:
        """Stop the timer and free the buttons."""
        super().cancel(context)
        context.window_manager.shape_google_duplicates.running = False
        if state.is_registered():
            state.current().duplicates.collecting = None

    def finish(self, context: Any, *, cancelled: bool) -> set[str]:
        """List the groups of congruent meshes; the search for similar shapes goes on in the background."""
        shown = context.window_manager.shape_google_duplicates
        if cancelled:
            shown.status = tr("Cancelled; nothing was changed")
            return {"CANCELLED"}
        found = self._collecting.found
        self._list_same(context, found)
        if self._solids:
            solids, meshes = zip(*self._solids, strict=True)
            source = model_source(context)
            similar = SimilarSearch(source, solids, meshes, len(found.hidden), shown.min_similarity)
            _begin(similar)
            similar.begin()
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """Find all groups before returning."""
        from shapegoogle_core import ShapeGoogleError

        shown = context.window_manager.shape_google_duplicates
        _cancel_running()
        try:
            hidden = self._find(context)
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        shown.status = summary(shown, hidden)
        self.report({"INFO"}, shown.status)
        return {"FINISHED"}

    def _find(self, context: Any) -> int:
        """Find all groups, waiting for the worker; returns the number of objects left out."""
        from shapegoogle_core.worker.grouping import describe_meshes, group_meshes
        from shapegoogle_core.worker.requests import library_duplicates

        from .groups import collect_shapes, library_groups, similar_groups, solid_shapes

        shown, worker = context.window_manager.shape_google_duplicates, jobs.worker()
        least = shown.min_similarity
        if shown.scope == "LIBRARY":
            groups = worker.submit(library_duplicates, library_address(context), least).result()
            show_groups(shown, library_groups(groups), "LIBRARY")
            return 0
        found = collect_shapes(context, context.scene.objects)
        self._list_same(context, found)
        read = list(solid_shapes(found)) if shown.similar else []
        if read:
            source = model_source(context)
            described = worker.submit(describe_meshes, source, [mesh for _, mesh in read]).result()
            similar = worker.submit(group_meshes, source, described, least).result()
            show_groups(shown, similar_groups([solid for solid, _ in read], similar), "SCENE", add=True)
        return len(found.hidden)

    def _list_same(self, context: Any, found: SceneShapes) -> None:
        """List the groups of congruent meshes of the scene."""
        from .groups import scene_groups

        shown = context.window_manager.shape_google_duplicates
        show_groups(shown, scene_groups(found), "SCENE")
        shown.status = summary(shown, len(found.hidden))
        if found.hidden:
            self.report(
                {"WARNING"},
                tr("Disabled in viewports or in excluded collections, and so left out: {names}").format(
                    names=_some(found.hidden)
                ),
            )
        if found.skipped:
            self.report(
                {"WARNING"},
                counted(
                    "{count} object has no extent or broken coordinates and was left out: {names}",
                    "{count} objects have no extent or broken coordinates and were left out: {names}",
                    len(found.skipped),
                    names=_some(found.skipped),
                ),
            )


class SHAPEGOOGLE_OT_cancel_duplicates(bpy.types.Operator):
    """End the search."""

    bl_idname = "shape_google.cancel_duplicates"
    bl_label = "Cancel Search for Duplicates"
    bl_description = "End the search for duplicates; the groups found stay listed"
    bl_options: ClassVar = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a search or a linking runs."""
        return bool(context.window_manager.shape_google_duplicates.running)

    def execute(self, _context: Any) -> set[str]:
        """End it."""
        _cancel_running()
        return {"FINISHED"}


class SHAPEGOOGLE_OT_select_duplicates(bpy.types.Operator):
    """Select a group."""

    bl_idname = "shape_google.select_duplicates"
    bl_label = "Select Duplicates"
    bl_description = "Select the members of a group that are in this scene, the first one active"
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    index: IntProperty(
        name="Group",
        description="Number of the group in the list, from 0; -1: the active one",
        default=-1,
        min=-1,
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a group and objects can be selected."""
        if not len(context.window_manager.shape_google_duplicates.groups):
            cls.poll_message_set(tr("Find duplicates first"))
            return False
        return is_in_object_mode(cls, context)

    def execute(self, context: Any) -> set[str]:
        """Select them."""
        shown = context.window_manager.shape_google_duplicates
        index = shown.index if self.index < 0 else self.index
        if not 0 <= index < len(shown.groups):
            text = tr("There is no group {number}; there are {count}")
            self.report({"ERROR"}, text.format(number=index, count=len(shown.groups)))
            return {"CANCELLED"}
        group = shown.groups[index]
        objects = objects_of(context, group, objects_by_name(context), shown.found_in)
        visible = [item for item in objects if item.visible_get(view_layer=context.view_layer)]
        if not visible:
            text = tr("No visible object of the group of {name!r} is in this scene")
            self.report({"WARNING"}, text.format(name=group.name))
            return {"CANCELLED"}
        for item in context.view_layer.objects.selected:
            item.select_set(False)
        for item in visible:
            item.select_set(True)
        context.view_layer.objects.active = visible[0]
        text = tr("Selected {selected} of {count}")
        self.report({"INFO"}, text.format(selected=len(visible), count=len(group.members)))
        return {"FINISHED"}


@persistent
def _forget(*_arguments: object) -> None:
    """Another file is opened: the groups are of the old one."""
    _cancel_running()
    state.current().duplicates.found.clear()
    shown = bpy.context.window_manager.shape_google_duplicates
    shown.groups.clear()
    shown.status, shown.running = "", False


def _forget_library(context: Any, reason: str) -> None:
    """Drop the groups of a library that is no longer the chosen one."""
    shown = context.window_manager.shape_google_duplicates
    if shown.found_in == "LIBRARY" or isinstance(state.current().duplicates.search, LibrarySearch):
        _cancel_running()
        shown.groups.clear()
        shown.status, shown.running = reason, False


_register, _unregister = bpy.utils.register_classes_factory(
    (
        SHAPEGOOGLE_OT_find_duplicates,
        SHAPEGOOGLE_OT_cancel_duplicates,
        SHAPEGOOGLE_OT_select_duplicates,
    )
)


def register() -> None:
    """Register the operators."""
    _register()
    bpy.app.handlers.load_pre.append(_forget)
    when_it_goes(_forget_library)


def unregister() -> None:
    """Unregister the operators."""
    _cancel_running()
    bpy.app.handlers.load_pre.remove(_forget)
    _unregister()
