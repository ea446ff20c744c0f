# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Library: which file, made from which sources, and how indexing goes."""

from __future__ import annotations

from typing import Any

import bpy

from .. import assets
from ..preferences import preferences
from ..properties import session_of
from .text import wrapped

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_UL_folders(bpy.types.UIList):
    """Folders whose shapes are indexed."""

    def draw_item(
        self,
        _context: Any,
        layout: Any,
        _data: Any,
        item: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        """Lay a folder out."""
        row = layout.row(align=True)
        row.prop(item, "use", text="")
        row.prop(item, "path", text="", emboss=False)


class SHAPEGOOGLE_UL_errors(bpy.types.UIList):
    """Files that were not indexed."""

    def draw_item(
        self,
        _context: Any,
        layout: Any,
        _data: Any,
        item: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        """Lay an error out."""
        layout.label(text=item.name, icon="ERROR")


class SHAPEGOOGLE_PT_library(bpy.types.Panel):
    """Choose the library, its sources, and index them."""

    bl_label = "Library"
    bl_category = "Shape Google"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_order = 10

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        chosen, session = preferences(context), session_of(context)
        path = chosen.library_path()
        row = layout.row(align=True)
        row.operator("shape_google.choose_library", text=path.name, icon="FILE_FOLDER")
        if session.shape_count:
            layout.label(text=f"{session.shape_count:,} shapes", icon="MESH_MONKEY")
        column = layout.column(align=True)
        names = [name for name, _ in assets.asset_libraries()]
        row = column.row()
        row.enabled = bool(names)
        row.prop(chosen, "use_asset_libraries", text=f"Asset Libraries ({len(names)})")
        column.prop(chosen, "use_scene")
        row = layout.row()
        row.template_list(
            "SHAPEGOOGLE_UL_folders", "", chosen, "folders", chosen, "active_folder", rows=2, maxrows=6
        )
        column = row.column(align=True)
        column.operator("shape_google.add_folder", text="", icon="ADD")
        column.operator("shape_google.remove_folder", text="", icon="REMOVE")
        layout.prop(chosen, "objects", text="")
        _draw_indexing(layout, session)
        if session.errors:
            _draw_errors(layout, session, context)


def _draw_indexing(layout: Any, session: Any) -> None:
    if session.indexing:
        row = layout.row(align=True)
        share = session.done / session.total if session.total else 0.0
        row.progress(factor=share, text=session.progress)
        row.operator("shape_google.cancel_indexing", text="", icon="CANCEL")
        return
    row = layout.row(align=True)
    row.scale_y = 1.3
    row.operator("shape_google.index_library", icon="FILE_REFRESH")
    row.menu("SHAPEGOOGLE_MT_indexing", text="", icon="DOWNARROW_HLT")
    if session.summary:
        layout.label(text=session.summary, icon="INFO")


def _draw_errors(layout: Any, session: Any, context: Any) -> None:
    row = layout.row()
    row.label(text=f"{len(session.errors)} not indexed", icon="ERROR")
    row.operator("shape_google.copy_errors", text="", icon="COPYDOWN")
    layout.template_list(
        "SHAPEGOOGLE_UL_errors", "", session, "errors", session, "active_error", rows=2, maxrows=6
    )
    if 0 <= session.active_error < len(session.errors):
        error = session.errors[session.active_error]
        wrapped(layout.box(), f"{error.path}: {error.reason}", context)


class SHAPEGOOGLE_MT_indexing(bpy.types.Menu):
    """Less usual ways to index."""

    bl_label = "Indexing"

    def draw(self, _context: Any) -> None:
        """Lay the menu out."""
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator("shape_google.index_library", text="Retry Failed Files").retry = True
        self.layout.operator("shape_google.index_library", text="Read All Files Again").reread = True
        self.layout.separator()
        self.layout.operator("shape_google.train_model")


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_UL_folders, SHAPEGOOGLE_UL_errors, SHAPEGOOGLE_PT_library, SHAPEGOOGLE_MT_indexing)
)
