# SPDX-License-Identifier: GPL-3.0-or-later
"""Connect to a library on a server, say where its roots are on this computer, and show both in the panel."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import bpy
from bpy.props import BoolProperty, StringProperty

from ..needs import draw_sentence
from ..preferences import preferences
from ..server import WHAT_IS_SENT, is_database_address
from ..state import session_of
from ..translation import error_text, tr
from ..wrapped_text import fixed_text
from .address import is_on_server, refusal
from .present import look_again

__all__ = ["draw_roots", "draw_service", "register", "unregister"]

WIDTH = 460


class SHAPEGOOGLE_OT_connect_service(bpy.types.Operator):
    """Search a library on a server."""

    bl_idname = "shape_google.connect_service"
    bl_label = "Connect to Server"
    bl_description = (
        "Search a library that a server offers, which shapegoogle serve runs there, or a database"
    )

    address: StringProperty(
        name="Address",
        description="Such as https://shapes.example, or postgresql://artist@server/shapes of a database",
        options={"SKIP_SAVE"},
    )
    token: StringProperty(
        name="Token",
        description=(
            "From whoever runs the server, or the password of the database; leave it empty if you have one "
            "there already"
        ),
        subtype="PASSWORD",
        options={"SKIP_SAVE"},
    )
    allow: BoolProperty(name="Search on a Server", description=WHAT_IS_SENT, options={"SKIP_SAVE"})

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask for the address."""
        chosen = preferences(context)
        if is_on_server(context):
            self.address = chosen.library
        self.allow = chosen.allow_network
        answer: set[str] = context.window_manager.invoke_props_dialog(self, width=WIDTH)
        return answer

    def draw(self, _context: Any) -> None:
        """Lay the dialog out."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "address", placeholder="https://shapes.example")
        layout.prop(self, "token")
        layout.prop(self, "allow")
        draw_sentence(layout, tr(WHAT_IS_SENT), letters=72, icon="INFO")

    def execute(self, context: Any) -> set[str]:
        """Take the address; the connection is made by the worker process."""
        from shapegoogle_core import LibraryError
        from shapegoogle_core.client import ServiceAddress

        chosen = preferences(context)
        address = self.address.strip()
        try:
            if not is_database_address(address):
                address = str(ServiceAddress.parse(address))
        except LibraryError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        chosen.library, chosen.allow_network = address, self.allow
        if self.token.strip():
            chosen.token = self.token
        context.preferences.is_dirty = True
        look_again(context)
        reason = refusal(context)
        if reason:
            self.report({"WARNING"}, reason)
        return {"FINISHED"}


class SHAPEGOOGLE_OT_map_root(bpy.types.Operator):
    """Say which folder a root of the library is on this computer."""

    bl_idname = "shape_google.map_root"
    bl_label = "Choose Folder of Root"
    bl_description = (
        "Say which folder of this computer has the files of this root of the library, so that matches can be "
        "appended, linked and opened"
    )

    root: StringProperty(options={"SKIP_SAVE", "HIDDEN"})
    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE"})
    filter_folder: BoolProperty(default=True, options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask for it."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Any) -> set[str]:
        """Keep it in the preferences."""
        folder = Path(bpy.path.abspath(self.directory))
        if not self.root or not folder.is_dir():
            self.report({"ERROR"}, tr("'{path}' is not a folder").format(path=folder))
            return {"CANCELLED"}
        roots = preferences(context).roots
        entry = next((root for root in roots if root.name == self.root), None)
        if entry is None:
            entry = roots.add()
            entry.name = self.root
        entry.path = str(folder)
        return {"FINISHED"}


class SHAPEGOOGLE_OT_add_root(bpy.types.Operator):
    """Add a root to the list."""

    bl_idname = "shape_google.add_root"
    bl_label = "Add Root"
    bl_description = "Add a root of a library, to say which folder it is on this computer"
    bl_options: ClassVar = {"INTERNAL"}

    def execute(self, context: Any) -> set[str]:
        """Add it."""
        chosen = preferences(context)
        chosen.roots.add()
        chosen.active_root = len(chosen.roots) - 1
        context.preferences.is_dirty = True
        return {"FINISHED"}


class SHAPEGOOGLE_OT_remove_root(bpy.types.Operator):
    """Remove a root from the list."""

    bl_idname = "shape_google.remove_root"
    bl_label = "Remove Root"
    bl_description = "Remove the root from the list; the library and the folder stay as they are"
    bl_options: ClassVar = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that one is chosen."""
        chosen = preferences(context)
        return bool(0 <= chosen.active_root < len(chosen.roots))

    def execute(self, context: Any) -> set[str]:
        """Remove it."""
        chosen = preferences(context)
        chosen.roots.remove(chosen.active_root)
        chosen.active_root = max(0, chosen.active_root - 1)
        look_again(context)
        context.preferences.is_dirty = True
        return {"FINISHED"}


def draw_service(layout: Any, context: Any) -> None:
    """Lay out what the panel shows of a library on a server, in place of its sources and of indexing.

    Parameters
    ----------
    layout : bpy.types.UILayout
    context : bpy.types.Context
    """
    session = session_of(context)
    reason = refusal(context)
    # The token, the certificate and the consent are there, so also where the server refuses.
    layout.operator(
        "preferences.addon_show", text="Open Preferences", icon="PREFERENCES"
    ).module = __package__.rpartition(".")[0]
    text = reason or session.connection or tr("Shapes are added on the server; here you search and decide")
    fixed_text(layout, f"{text[:1].upper()}{text[1:]}", context)
    draw_roots(layout, context)


def draw_roots(layout: Any, context: Any) -> None:
    """Lay out which folders of this computer the roots of the library are.

    Parameters
    ----------
    layout : bpy.types.UILayout
    context : bpy.types.Context
    """
    session = session_of(context)
    header, body = layout.panel("SHAPEGOOGLE_roots", default_closed=not is_on_server(context))
    header.label(text="Folders of Roots")
    if body is None:
        return
    folders = dict(preferences(context).root_folders())
    for root in session.roots:
        split = body.split(factor=0.35)
        split.label(text=root.name, translate=False)
        folder = folders.get(root.name, root.path)
        operator = split.operator(
            "shape_google.map_root",
            text=folder or tr("Choose Folder"),
            icon="FILE_FOLDER" if folder else "QUESTION",
            translate=False,
        )
        operator.root = root.name


register, unregister = bpy.utils.register_classes_factory(
    (
        SHAPEGOOGLE_OT_connect_service,
        SHAPEGOOGLE_OT_map_root,
        SHAPEGOOGLE_OT_add_root,
        SHAPEGOOGLE_OT_remove_root,
    )
)
