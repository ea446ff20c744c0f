# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose the library and the folders that it is made from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty

from ..preferences import LIBRARY_SUFFIX, preferences
from ..state import session_of
from ..translation import error_text, tr
from .address import is_on_server

__all__ = ["register", "unregister"]


class SHAPEGOOGLE_OT_choose_library(bpy.types.Operator):
    """Choose the library file."""

    bl_idname = "shape_google.choose_library"
    bl_label = "Choose Library"
    bl_description = "Choose a library file, or name a new one, which is created when you first index into it"

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default=f"*{LIBRARY_SUFFIX}", options={"HIDDEN"})

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask for it."""
        chosen = preferences(context)
        # The file browser cannot begin at a server.
        path = chosen.libraries_folder() / f"shapes{LIBRARY_SUFFIX}"
        self.filepath = str(path if is_on_server(context) else chosen.library_path())
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Any) -> set[str]:
        """Take it."""
        path = Path(bpy.path.abspath(self.filepath))
        if path.is_dir() or not path.name:
            text = tr("'{path}' is a folder; name a file in it, such as {example}")
            self.report({"ERROR"}, text.format(path=path, example=f"shapes{LIBRARY_SUFFIX}"))
            return {"CANCELLED"}
        path = path if path.suffix else path.with_suffix(LIBRARY_SUFFIX)
        preferences(context).library = str(path)
        context.preferences.is_dirty = True
        session = session_of(context)
        if path.exists():
            return self._open(path, session)
        return {"FINISHED"}

    def _open(self, path: Path, session: Any) -> set[str]:
        from shapegoogle_core import Library, LibraryError

        try:
            with Library.open(path, read_only=True) as library:
                session.shape_count, session.model = len(library), library.model.name
        except LibraryError as error:
            self.report({"ERROR"}, error_text(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class SHAPEGOOGLE_OT_add_folder(bpy.types.Operator):
    """Add a folder to the sources."""

    bl_idname = "shape_google.add_folder"
    bl_label = "Add Folder"
    bl_description = "Add a folder whose .blend and mesh files are indexed, with all folders below it"

    directory: StringProperty(subtype="DIR_PATH")

    def invoke(self, context: Any, _event: Any) -> set[str]:
        """Ask for it."""
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Any) -> set[str]:
        """Add it."""
        chosen = preferences(context)
        path = Path(bpy.path.abspath(self.directory))
        if not path.is_dir():
            self.report({"ERROR"}, tr("'{path}' is not a folder").format(path=path))
            return {"CANCELLED"}
        if all(Path(item.path) != path for item in chosen.folders):
            item = chosen.folders.add()
            item.name, item.path = path.name, str(path)
            chosen.active_folder = len(chosen.folders) - 1
            context.preferences.is_dirty = True
        return {"FINISHED"}


class SHAPEGOOGLE_OT_remove_folder(bpy.types.Operator):
    """Remove a folder from the sources."""

    bl_idname = "shape_google.remove_folder"
    bl_label = "Remove Folder"
    bl_description = (
        "Remove the folder from the list; its shapes stay in the library, and its files unchanged"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        """Check that a folder is chosen."""
        chosen = preferences(context)
        return bool(0 <= chosen.active_folder < len(chosen.folders))

    def execute(self, context: Any) -> set[str]:
        """Remove it."""
        chosen = preferences(context)
        chosen.folders.remove(chosen.active_folder)
        chosen.active_folder = max(0, chosen.active_folder - 1)
        context.preferences.is_dirty = True
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (SHAPEGOOGLE_OT_choose_library, SHAPEGOOGLE_OT_add_folder, SHAPEGOOGLE_OT_remove_folder)
)
