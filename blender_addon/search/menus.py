# SPDX-License-Identifier: GPL-3.0-or-later
"""*Find Similar* where artists look for it: in the context menus, and as a shortcut."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from .. import jobs
from ..library.address import library_address
from ..library.status_bar import tell
from ..state import session_of
from ..translation import error_text, tr
from .operators import search_with

if TYPE_CHECKING:
    from concurrent.futures import Future

__all__ = ["KEYMAP", "register", "unregister"]

KEYMAP = ("3D View", "VIEW_3D")
"""Key map of the shortcut, and the editor that it works in."""

# Menus and the operator that they get.
_MENUS = {
    "VIEW3D_MT_object_context_menu": "shape_google.find_similar",
    "VIEW3D_MT_edit_mesh_context_menu": "shape_google.find_similar",
    "OUTLINER_MT_object": "shape_google.find_similar",
    "ASSETBROWSER_MT_context_menu": "shape_google.find_similar_asset",
}
# An asset may be marked in the open file, as one of these.
_TYPES = ("OBJECT", "COLLECTION")


class SHAPEGOOGLE_OT_find_similar_asset(bpy.types.Operator):
    """Find shapes like an asset."""

    bl_idname = "shape_google.find_similar_asset"
    bl_label = "Find Similar"
    bl_description = (
        "Find the shapes of the library that are most like the active asset; the matches are shown in the "
        "sidebar of the 3D view"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that an asset is active that can be a shape."""
        asset = getattr(context, "asset", None)
        if asset is None or asset.id_type not in _TYPES:
            cls.poll_message_set(tr("Choose an object or a collection among the assets"))
            return False
        if session_of(context).searching:
            cls.poll_message_set(tr("A search is already running"))
            return False
        return True

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Look for the asset in the library without stopping the window, then search with it."""
        name, source, future = self._ask(context)

        def done(found: tuple[int, str] | None) -> None:
            if found is None:
                _say(_not_there(name, source))
            else:
                search_with(bpy.context, found)

        def failed(error: BaseException) -> None:
            _say(error_text(error))

        jobs.watch(future, done, failed)
        text = tr("Searching for {name}; the matches are in the sidebar of the 3D view")
        self.report({"INFO"}, text.format(name=name))
        return {"FINISHED"}

    def execute(self, context: Any) -> set[str]:
        """Search with the shape that the asset is in the library."""
        from shapegoogle_core import ShapeGoogleError

        name, source, future = self._ask(context)
        try:
            found = future.result()
        except ShapeGoogleError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        if found is None:
            self.report({"ERROR"}, _not_there(name, source))
            return {"CANCELLED"}
        search_with(context, found)
        text = tr("Searching for {name}; the matches are in the sidebar of the 3D view")
        self.report({"INFO"}, text.format(name=found[1]))
        return {"FINISHED"}

    def _ask(self, context: Any) -> tuple[str, str, Future[tuple[int, str] | None]]:
        """Have the worker look for the asset; return its name and file too."""
        from shapegoogle_core.worker.assets import shape_of

        asset = context.asset
        source = asset.full_library_path or bpy.data.filepath
        find = partial(shape_of, is_collection=asset.id_type == "COLLECTION")
        name = str(asset.name)
        return name, source, jobs.worker().submit(find, library_address(context), source, name)


def _say(text: str) -> None:
    """Show a sentence in place of an answer, and in the status bar, which Asset Browsers have, too."""
    session_of(bpy.context).answer = text
    tell(bpy.context, text)


def _not_there(name: str, source: str) -> str:
    where = Path(source).name or tr("the open file")
    text = tr("{name!r} of {file} is not in the library; Index Library with its folder first")
    return text.format(name=name, file=where)


def _draw_find_similar(self: Any, _context: Any) -> None:
    _draw(self.layout, "shape_google.find_similar")


def _draw_find_similar_asset(self: Any, _context: Any) -> None:
    _draw(self.layout, "shape_google.find_similar_asset")


_DRAW = {
    "shape_google.find_similar": _draw_find_similar,
    "shape_google.find_similar_asset": _draw_find_similar_asset,
}


def _draw(layout: Any, operator: str) -> None:
    layout.separator()
    layout.operator_context = "INVOKE_DEFAULT"
    layout.operator(operator, icon="VIEWZOOM")


_register, _unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_OT_find_similar_asset,))


def register() -> None:
    """Register the operator, the entries of menus and the shortcut."""
    _register()
    for menu, operator in _MENUS.items():
        getattr(bpy.types, menu).append(_DRAW[operator])
    keys = bpy.context.window_manager.keyconfigs.addon
    if keys is not None:  # not in the background
        name, space = KEYMAP
        keymap = keys.keymaps.new(name=name, space_type=space)
        keymap.keymap_items.new("shape_google.find_similar", "F", "PRESS", ctrl=True, shift=True, alt=True)


def unregister() -> None:
    """Remove the shortcut, the entries of menus and the operator."""
    keys = bpy.context.window_manager.keyconfigs.addon
    keymap = None if keys is None else keys.keymaps.get(KEYMAP[0])
    if keymap is not None:
        for entry in [entry for entry in keymap.keymap_items if entry.idname == "shape_google.find_similar"]:
            keymap.keymap_items.remove(entry)
    for menu, operator in _MENUS.items():
        getattr(bpy.types, menu).remove(_DRAW[operator])
    _unregister()
