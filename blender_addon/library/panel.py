# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Library: the file, its sources, its model, and the progress of indexing and training.

All rows are always there, with the same heights: what comes and goes while work runs in the background would
move the buttons of this panel and of all below it under the pointer.
"""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

import bpy

from .. import connections
from ..preferences import preferences
from ..progress_bar import progress_bar
from ..sidebar import SidebarPanel
from ..state import session_of
from ..translation import counted, tr
from ..wrapped_text import fixed_text
from .address import is_on_server
from .present import follow, is_there
from .service import draw_roots, draw_service

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
        # The sidebar is too narrow for a path; that of the active folder is below the list.
        row.label(text=PurePath(item.path.rstrip("/\\")).name or item.path, translate=False)


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
        layout.label(text=item.name, translate=False, icon="FILE")


class SHAPEGOOGLE_PT_library(SidebarPanel, bpy.types.Panel):
    """Choose the library, its sources, and index them."""

    bl_label = "Library"
    bl_order = 10

    def draw_header_preset(self, context: Any) -> None:
        """Show the number of shapes at the right of the title, and the button of the manual."""
        count = session_of(context).shape_count
        if count:
            text = counted("{count:,} shape", "{count:,} shapes", count)
            self.layout.label(text=text, translate=False)
        self.layout.operator("shape_google.open_manual", text="", icon="HELP", emboss=False)

    def draw(self, context: Any) -> None:
        """Lay the panel out."""
        layout = self.layout
        follow(context)
        chosen, session = preferences(context), session_of(context)
        row = layout.row(align=True)
        name = chosen.library if is_on_server(context) else chosen.library_path().name
        row.operator("shape_google.choose_library", text=name, icon="FILE_FOLDER", translate=False)
        row.operator("shape_google.connect_service", text="", icon="URL")
        if is_on_server(context):
            draw_service(layout, context)
            return
        _draw_sources(layout, chosen, session, context)
        _draw_indexing(layout, session, context)
        _draw_model(layout, session, context)
        _draw_errors(layout, session, context)


def _draw_sources(layout: Any, chosen: Any, session: Any, context: Any) -> None:
    header, body = layout.panel_prop(session, "show_sources")
    header.label(text="Sources")
    if body is None:
        return
    column = body.column(align=True)
    libraries = len(connections.asset_libraries())
    row = column.row()
    row.enabled = libraries > 0
    text = tr("Asset Libraries ({count})").format(count=libraries)
    row.prop(chosen, "use_asset_libraries", text=text, translate=False)
    column.prop(chosen, "use_scene")
    row = body.row()
    row.template_list(
        "SHAPEGOOGLE_UL_folders", "", chosen, "folders", chosen, "active_folder", rows=3, maxrows=3
    )
    column = row.column(align=True)
    column.operator("shape_google.add_folder", text="", icon="ADD")
    column.operator("shape_google.remove_folder", text="", icon="REMOVE")
    is_chosen = 0 <= chosen.active_folder < len(chosen.folders)
    fixed_text(body, chosen.folders[chosen.active_folder].path if is_chosen else "", context, lines=1)
    split = body.split(factor=0.3)
    split.label(text="Objects")
    split.prop(chosen, "objects", text="")
    split = body.split(factor=0.3)
    split.label(text="Frames")
    split.prop(chosen, "frames", text="", placeholder="such as 1,10,20")
    draw_roots(body, context)


def _draw_indexing(layout: Any, session: Any, context: Any) -> None:
    row = layout.row(align=True)
    row.scale_y = 1.3
    if session.indexing:
        progress_bar(row, session, "percent")
        row.operator("shape_google.cancel_indexing", text="", icon="X")
    else:
        row.operator("shape_google.index_library", icon="FILE_REFRESH")
        row.menu("SHAPEGOOGLE_MT_indexing", text="", icon="DOWNARROW_HLT")
    said = session.progress if session.indexing else session.summary
    fixed_text(layout, said or _advice(session) or _first_step(context), context)


def _first_step(context: Any) -> str:
    """Say what to do where there is no library yet."""
    if is_there(context):
        return ""
    return tr("Choose This Scene or add a folder, then Index Library")


def _advice(session: Any) -> str:
    """Say what a library of an earlier version lacks."""
    if not session.without_views:
        return ""
    if session.without_views >= session.shape_count:
        return tr(
            "All shapes were described by an earlier version: more of the same kind is found among them only "
            "after Index Library has read their files again"
        )
    return counted(
        "{count:,} shape was described by an earlier version: Find Similar finds it for others of its kind "
        "only after Index Library has read its file again",
        "{count:,} shapes were described by an earlier version: more of the same kind is found among them "
        "only after Index Library has read their files again",
        session.without_views,
    )


def _draw_model(layout: Any, session: Any, context: Any) -> None:
    header, body = layout.panel_prop(session, "show_model")
    model = session.model or _model_of_new(preferences(context), context)
    template = tr("Training: {progress}") if session.training else tr("Model: {model}")
    header.label(text=template.format(progress=session.training, model=model), translate=False)
    header.operator("shape_google.cancel_training", text="", icon="X", emboss=False)
    if body is None:
        return
    body.operator("shape_google.train_model", icon="FILE_REFRESH")
    fixed_text(body, session.training or session.trained, context)


def _model_of_new(chosen: Any, context: Any) -> str:
    """Name the model of a library that is not there yet."""
    if is_there(context):
        return "…"  # the worker process has not opened it yet
    name = PurePath(chosen.model_file).stem if chosen.model == "FILE" else chosen.model.lower()
    return tr("{model}, for the new library").format(model=name)


def _draw_errors(layout: Any, session: Any, context: Any) -> None:
    header, body = layout.panel_prop(session, "show_errors")
    count = len(session.errors)
    text = tr("Not Indexed: {count:,}").format(count=count)
    header.label(text=text, translate=False, icon="ERROR" if count else "NONE")
    header.operator("shape_google.copy_errors", text="", icon="COPYDOWN")
    if body is None:
        return
    body.template_list(
        "SHAPEGOOGLE_UL_errors", "", session, "errors", session, "active_error", rows=3, maxrows=3
    )
    error = session.errors[session.active_error] if 0 <= session.active_error < count else None
    fixed_text(body, error.path if error else "", context, lines=1)
    fixed_text(body, error.reason if error else "", context, lines=3)


class SHAPEGOOGLE_MT_indexing(bpy.types.Menu):
    """Other ways to index."""

    bl_label = "Indexing"

    def draw(self, _context: Any) -> None:
        """Lay the menu out."""
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator("shape_google.index_library", text="Retry Failed Files").retry = True
        self.layout.operator("shape_google.index_library", text="Read All Files Again").reread = True
        self.layout.separator()
        self.layout.operator("shape_google.move_sources", text="Move Sources…")
        self.layout.operator("shape_google.forget_folder", text="Forget Folder…")
        self.layout.operator("shape_google.forget_missing", text="Forget Missing Files…")
        self.layout.separator()
        self.layout.operator("shape_google.train_model")


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_UL_folders, SHAPEGOOGLE_UL_errors, SHAPEGOOGLE_PT_library, SHAPEGOOGLE_MT_indexing)
)
