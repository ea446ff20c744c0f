# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint signatures, words and keypoints onto the selected objects, and clear them again."""

from __future__ import annotations

from typing import Any, ClassVar

import bpy

from .. import state
from ..scene.selection import CARRIERS, mesh_objects, meshes_of
from ..state.parts import SignatureState
from ..translation import counted, tr
from . import bag_chart, shading
from .painter import MODES, Painter

__all__ = ["register", "unregister"]


def _poll(operator: Any, context: Any) -> bool:
    if context.mode not in MODES:
        operator.poll_message_set(tr("Switch to object mode or to edit mode of a mesh"))
        return False
    if not any(item.type in ("MESH", *CARRIERS) for item in context.selected_objects):
        operator.poll_message_set(tr("Select at least one mesh object"))
        return False
    return True


def _meshes(context: Any) -> list[Any]:
    """Return the selected meshes; without any, those of the selected rigs, lattices and empties."""
    selected = context.selected_objects
    return mesh_objects(selected) or [mesh for item in selected for mesh in meshes_of(item, context)]


class SHAPEGOOGLE_OT_paint(Painter, bpy.types.Operator):
    """Paint the signature chosen in the panel."""

    bl_idname = "shape_google.paint"
    bl_label = "Paint Signature"
    bl_description = (
        "Write the chosen signature onto the vertices of the selected objects, as attributes whose names "
        "begin with sg_. This 3D view is set to solid shading with attribute colors, until undo or Clear "
        "Signature. Objects are computed as they are before modifiers, in world scale, and those with very "
        "many vertices on a simplified copy: 100,000 vertices take a few seconds"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a mesh to paint."""
        return _poll(cls, context)

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Run long computations in the worker process, then paint."""
        meshes = self._meshes(context)
        return self.paint_in_background(context, meshes) if meshes else {"CANCELLED"}

    def execute(self, context: Any) -> set[str]:
        """Compute and paint at once."""
        meshes = self._meshes(context)
        return self.paint_at_once(context, meshes) if meshes else {"CANCELLED"}

    def _meshes(self, context: Any) -> list[Any]:
        """Find what to paint; none after a report."""
        meshes = _meshes(context)
        if not meshes:
            text = tr("{name!r} has no visible mesh; select a mesh")
            self.report({"ERROR"}, text.format(name=context.selected_objects[0].name))
        return meshes


class SHAPEGOOGLE_OT_clear_paint(bpy.types.Operator):
    """Clear painted attributes."""

    bl_idname = "shape_google.clear_paint"
    bl_label = "Clear Signature"
    bl_description = (
        "Remove all attributes whose names begin with sg_ from the selected objects, and nothing else. The "
        "colors and the shading that were shown before painting come back"
    )
    bl_options: ClassVar = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that there is a mesh."""
        return _poll(cls, context)

    def execute(self, context: Any) -> set[str]:
        """Remove them."""
        from . import attributes, painting

        items, refused = painting.targets(_meshes(context))
        for reason in refused:
            self.report({"WARNING"}, reason)
        removed = [attributes.clear(item.data) for item in items]
        shading.restore_unpainted(context)
        count, meshes = sum(map(len, removed)), sum(map(bool, removed))
        if not count:
            self.report(
                {"INFO"}, tr("Nothing to clear: the selected objects have no attributes of Shape Google")
            )
            return {"CANCELLED"}
        attributes_text = counted("{count} attribute", "{count} attributes", count)
        meshes_text = counted("{count} mesh", "{count} meshes", meshes)
        text = tr("Removed {attributes} from {meshes}")
        self.report({"INFO"}, text.format(attributes=attributes_text, meshes=meshes_text))
        return {"FINISHED"}


@bpy.app.handlers.persistent
def _forget(*_arguments: Any) -> None:
    """Drop all results: another file is opened, or the add-on is switched off."""
    bag_chart.clear()
    state.current().signature = SignatureState()


@bpy.app.handlers.persistent
def _look_again(*_arguments: Any) -> None:
    """Restore views that outlasted the opening of a file, if it has no painted colours."""
    shading.restore_unpainted(bpy.context)
    state.current().signature.restored_views = []


@bpy.app.handlers.persistent
def _follow_undo(*_arguments: Any) -> None:
    """Undo or redo may have removed painted colours, or brought them back."""
    shading.follow_undo(bpy.context)


_register, _unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_paint, SHAPEGOOGLE_OT_clear_paint)
)


def register() -> None:
    """Register the operators."""
    _register()
    bpy.app.handlers.load_pre.append(_forget)
    bpy.app.handlers.load_post.append(_look_again)
    bpy.app.handlers.undo_post.append(_follow_undo)
    bpy.app.handlers.redo_post.append(_follow_undo)


def unregister() -> None:
    """Unregister the operators and drop all results."""
    bpy.app.handlers.redo_post.remove(_follow_undo)
    bpy.app.handlers.undo_post.remove(_follow_undo)
    bpy.app.handlers.load_post.remove(_look_again)
    bpy.app.handlers.load_pre.remove(_forget)
    _unregister()
    _forget()
