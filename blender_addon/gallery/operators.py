# SPDX-License-Identifier: GPL-3.0-or-later
"""Use a match: append it, link it, open its file, select it, or mark it and the query in the same words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import bpy
from bpy.props import BoolProperty

from .. import state
from ..library.address import is_on_server
from ..library.open_file import is_open_file
from ..scene.selection import CARRIERS, mesh_objects, meshes_of
from ..signature.painter import Painter
from ..translation import counted, error_text, tr
from . import finding, free_place, placing
from .errors import PlacingError
from .on_match import OnMatch, active_match

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_OT_append_match(OnMatch, bpy.types.Operator):
    """Append the match."""

    bl_idname = "shape_google.append_match"
    bl_label = "Append"
    bl_description = (
        "Copy the match to the 3D cursor of this scene, or beside the query if it would be inside it; mesh "
        "files are imported"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    keep_asset: BoolProperty(
        name="Keep Asset Mark", description="The copy is an asset too if the match is one", default=True
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that the match is not in this scene."""
        if not super().poll(context):
            return False
        if active_match(context).in_scene:
            cls.poll_message_set(tr("The match is in this scene: select it, or choose another one"))
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        """Append it."""
        match = active_match(context)
        parts = free_place.query_parts(context)
        try:
            objects = placing.bring_in(context, match.source, finding.sought(match))
        except PlacingError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        free_place.put_at_cursor(context, objects, parts)
        for item in objects:
            if item.asset_data is not None and not self.keep_asset:
                item.asset_clear()
        self.report({"INFO"}, tr("Appended {name}").format(name=_name_of(objects[0], match)))
        return {"FINISHED"}


class SHAPEGOOGLE_OT_link_match(OnMatch, bpy.types.Operator):
    """Link the match."""

    bl_idname = "shape_google.link_match"
    bl_label = "Link"
    bl_description = (
        "Link the match into this scene at the place it has in its file; its data stays in that file"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that the match is in another .blend file."""
        match = active_match(context)
        if match is None or not match.source.lower().endswith(".blend"):
            cls.poll_message_set(tr("Only objects of .blend files can be linked; append this one"))
            return False
        if is_open_file(match.source):
            cls.poll_message_set(tr("The match is in this file"))
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        """Link it."""
        match = active_match(context)
        is_object = match.shape_type != "collection"
        linked = placing.find_linked(match.source, match.object_name) if is_object else None
        if linked is not None and linked in set(context.view_layer.objects):
            placing.to_object_mode(context)
            placing.select_only(context, [linked])
            self.report(
                {"INFO"}, tr("{name} is linked here already; it is selected now").format(name=linked.name)
            )
            return {"FINISHED"}
        try:
            objects = placing.bring_in(context, match.source, finding.sought(match), link=True)
        except PlacingError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        self.report({"INFO"}, tr("Linked {name}").format(name=_name_of(objects[0], match)))
        return {"FINISHED"}


class SHAPEGOOGLE_OT_open_match(OnMatch, bpy.types.Operator):
    """Open the file of the match."""

    bl_idname = "shape_google.open_match"
    bl_label = "Open File"
    bl_description = (
        "Open the .blend file of the match; Blender asks first whether to save changes of this file"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that the match is in a .blend file."""
        match = active_match(context)
        if match is None or not match.source.lower().endswith(".blend"):
            cls.poll_message_set(tr("Only .blend files can be opened; append this match"))
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Open it as File > Open does, with its question for unsaved changes."""
        return self._open(context, "INVOKE_DEFAULT")

    def execute(self, context: Any) -> set[str]:
        """Open it at once."""
        return self._open(context, "EXEC_DEFAULT")

    def _open(self, context: Any, how: str) -> set[str]:
        source = active_match(context).source
        state.current().search.file_wanted = source  # whose objects the matches stay for
        try:
            if is_on_server(context):
                placing.check_place(source)
        except PlacingError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        try:
            # Scripts in it stay off regardless of the preferences, since the file comes from a search.
            bpy.ops.wm.open_mainfile(how, filepath=source, display_file_selector=False, use_scripts=False)
        except RuntimeError as error:
            self.report({"ERROR"}, f"{source}: {str(error).strip()}")
            return {"CANCELLED"}
        return {"FINISHED"}


class SHAPEGOOGLE_OT_select_match(OnMatch, bpy.types.Operator):
    """Select the match."""

    bl_idname = "shape_google.select_match"
    bl_label = "Select"
    bl_description = (
        "Select the match, which is in this scene, and look at it. If several objects show its mesh, the one "
        "that fits best comes first, and each further click selects the next; with Shift all of them"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    all: BoolProperty(
        name="All", description="Select all objects that show the mesh of the match", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that the match is in this scene."""
        match = active_match(context)
        if match is None or not match.in_scene:
            cls.poll_message_set(tr("The match is not in this scene; append it"))
            return False
        return True

    def invoke(self, context: Any, event: Any) -> set[str]:
        """Select all with Shift."""
        self.all = self.all or event.shift
        return self.execute(context)

    def execute(self, context: Any) -> set[str]:
        """Select it, or the next object with its mesh if it is the selected one."""
        match = active_match(context)
        try:
            items = finding.placements_here(context, match)
        except PlacingError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        index = 0
        if not self.all:
            active = context.view_layer.objects.active
            if list(context.view_layer.objects.selected) == [active] and active in items:
                index = (items.index(active) + 1) % len(items)
        chosen = items if self.all else [items[index]]
        placing.to_object_mode(context)
        placing.select_only(context, chosen)
        if context.region is not None and context.area is not None and context.area.type == "VIEW_3D":
            for region in context.area.regions:
                if region.type == "WINDOW":
                    with context.temp_override(region=region):
                        bpy.ops.view3d.view_selected()
        if len(items) == 1:
            text = tr("Selected {name}").format(name=_name_of(items[0], match))
        elif self.all:
            text = counted("Selected {count} object", "Selected {count} objects", len(items))
        else:
            text = tr("Selected {name}, {number} of {count} with this mesh").format(
                name=chosen[0].name, number=index + 1, count=len(items)
            )
        self.report({"INFO"}, text)
        return {"FINISHED"}


class SHAPEGOOGLE_OT_mark_match(OnMatch, Painter, bpy.types.Operator):
    """Mark query and match in the same words."""

    bl_idname = "shape_google.mark_match"
    bl_label = "Mark"
    bl_description = (
        "Color the active object and the match by geometric word: similar parts of both get the same "
        "color. A match that is not in this scene is appended beside the active object"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a match and an object to compare it with."""
        if not super().poll(context):
            return False
        if context.active_object is None or context.active_object.type not in ("MESH", *CARRIERS):
            cls.poll_message_set(tr("Select the object that you searched with"))
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Bring the match beside the object, and paint both without stopping the window."""
        objects = self._prepare(context)
        return {"CANCELLED"} if objects is None else self.paint_in_background(context, objects)

    def execute(self, context: Any) -> set[str]:
        """Bring the match beside the object and paint both."""
        objects = self._prepare(context)
        return {"CANCELLED"} if objects is None else self.paint_at_once(context, objects)

    def lacking(self, items: Sequence[Any]) -> str:
        """Refuse to paint only one of the two, which would compare nothing."""
        meshes = {item.data.session_uid for item in items}
        for name, uids in self._sides:
            if not meshes & uids:
                return tr("{name!r} cannot be painted, so there is nothing to compare").format(name=name)
        return ""

    def take_back(self, context: Any) -> None:
        """Remove the appended objects; restore the selection and the settings."""
        # An undo may have removed some meanwhile; those that a redo restored keep their number.
        placing.remove(
            context, [block for block in bpy.data.user_map() if block.session_uid in self._appended]
        )
        objects = context.view_layer.objects
        for item in objects:
            item.select_set(item.session_uid in self._selected)
            if item.session_uid == self._query:
                objects.active = item
        settings = context.scene.shape_google_painting
        settings.kind, settings.color = self._shown

    def _prepare(self, context: Any) -> list[Any] | None:
        """Select the object and the match, which is appended if necessary; None after a report."""
        match = active_match(context)
        placing.to_object_mode(context)
        query = context.active_object
        # By number, since references do not survive an undo while the worker computes.
        self._query = query.session_uid
        self._selected = {item.session_uid for item in context.view_layer.objects.selected}
        self._appended: set[int] = set()
        settings = context.scene.shape_google_painting
        self._shown = settings.kind, settings.color
        there = set(context.view_layer.objects)
        parts = [part for part in meshes_of(query, context) if part in there]
        reason, here = "", None
        if not parts:
            reason = tr(
                "{name!r} has no mesh in this view layer that can be painted; select the mesh itself"
            ).format(name=query.name)
        try:
            here = finding.object_of(context, match)
        except PlacingError as error:
            reason = error_text(error)
        if reason:
            self._give_up(context, reason)
            return None
        others: list[Any] = [here]
        if here is None:
            before = set(bpy.data.user_map())
            reason = ""
            try:
                objects = placing.bring_in(context, match.source, finding.sought(match))
                # A mesh file is one shape, even if it is imported as several objects.
                is_blend = match.source.lower().endswith(".blend")
                others = objects[:1] if is_blend else mesh_objects(objects)
                if not others:
                    reason = tr(
                        "{name!r} contains no mesh any more; Index Library reads the changed file"
                    ).format(name=match.name)
            except PlacingError as error:
                reason = error_text(error)
            self._appended = {block.session_uid for block in bpy.data.user_map() if block not in before}
            if reason:
                self._give_up(context, reason)
                return None
            free_place.put_beside(context, objects, parts)
        objects = list(dict.fromkeys([*parts, *others]))
        placing.select_only(context, list(dict.fromkeys([query, *objects])))
        self._sides = [
            (query.name, {part.data.session_uid for part in parts}),
            (match.name, {item.data.session_uid for item in others}),
        ]
        settings.kind, settings.color = "WORDS", True
        return objects


def _name_of(item: Any, match: Any) -> str:
    """Return the name of an object, and the one that it had when it was indexed if that was another one."""
    if match.object_name and item.name.partition(".")[0] != match.object_name.partition(".")[0]:
        return tr("{name} (was {old})").format(name=item.name, old=match.object_name)
    return str(item.name)


register, unregister = bpy.utils.register_classes_factory(
    (
        SHAPEGOOGLE_OT_append_match,
        SHAPEGOOGLE_OT_link_match,
        SHAPEGOOGLE_OT_open_match,
        SHAPEGOOGLE_OT_select_match,
        SHAPEGOOGLE_OT_mark_match,
    )
)
