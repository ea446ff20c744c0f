# SPDX-License-Identifier: GPL-3.0-or-later
"""Select the keypoints that were painted."""

from __future__ import annotations

from typing import Any, ClassVar

import bpy

from ..scene.selection import mesh_objects
from ..translation import counted, tr
from .choices import KEYPOINT
from .painter import MODES

__all__ = ["register", "unregister"]


def _painted(context: Any) -> list[Any]:
    """Return the selected objects with keypoints on a mesh that can be edited, the active one first."""
    items = mesh_objects(context.selected_objects)
    items.sort(key=lambda item: item != context.active_object)
    return [item for item in items if item.data.is_editable and KEYPOINT in item.data.attributes]


class SHAPEGOOGLE_OT_select_keypoints(bpy.types.Operator):
    """Select the vertices that are keypoints."""

    bl_idname = "shape_google.select_keypoints"
    bl_label = "Select Keypoints"
    bl_description = (
        "Enter edit mode with vertex selection and select the vertices of the selected objects whose "
        "sg_keypoint is more than 0, and no others"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there are keypoints."""
        if context.mode not in MODES:
            cls.poll_message_set(tr("Switch to object mode or to edit mode of a mesh"))
            return False
        if not _painted(context):
            cls.poll_message_set(tr("Paint keypoints onto the selected objects first"))
            return False
        return True

    def execute(self, context: Any) -> set[str]:
        """Select them."""
        from . import attributes

        items = _painted(context)
        points = {item.data: attributes.positive_vertices(item.data, KEYPOINT) for item in items}
        total = sum(map(len, points.values()))
        if not total:
            self.report({"INFO"}, tr("The detector has found no keypoints on the selected objects"))
            return {"CANCELLED"}
        if context.mode == "OBJECT":
            # The active object decides which type of object is edited: all selected ones of its type are.
            if context.active_object is None or context.active_object.type != "MESH":
                context.view_layer.objects.active = items[0]
            bpy.ops.object.mode_set(mode="EDIT")
        # Not `context.tool_settings`: in Blender 4.2 and 4.3 asking for it makes this scene the owner of the
        # context itself, and once the scene is freed whatever is set by way of the context may crash.
        context.scene.tool_settings.mesh_select_mode = (True, False, False)
        edited = {item.data for item in context.objects_in_mode}
        count = sum(attributes.select(data, points.get(data, ())) for data in edited)
        text = counted("Selected {count} keypoint", "Selected {count} keypoints", count)
        if count < total:
            text = counted(
                "{selected}; {count} more is hidden or not being edited",
                "{selected}; {count} more are hidden or not being edited",
                total - count,
                selected=text,
            )
        self.report({"INFO"}, text)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_OT_select_keypoints,))
