# SPDX-License-Identifier: GPL-3.0-or-later
"""Preferences: the library and its sources, workers, limits, and the model."""

from __future__ import annotations

import getpass
import os
import re
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, StringProperty

from . import connections, needs
from .server import (
    ServerPreferences,
    is_database_address,
    is_server_address,
    keep_password,
    user_folder,
)

__all__ = ["preferences", "register", "unregister"]

LIBRARY_SUFFIX = ".sglib"

_OBJECTS = (
    ("ALL", "All Objects", "Every object with a surface, of every file"),
    (
        "ASSETS",
        "Assets First",
        "Only objects marked as assets, alone or with their collection; all of a file that has none",
    ),
)
_MODELS = (
    ("DEFAULT", "Default", "Finds shapes again in another pose, size and mesh"),
    ("PAPER", "Paper", "The parameters of the authors of Shape Google, for comparison"),
    ("FILE", "From File", "A model that was trained on your own shapes"),
)


def _absolute(name: str, *, of_library: bool = False) -> Callable[[Any, Any], None]:
    """Return an update function that makes a path absolute, so that it does not depend on the open file."""

    def update(group: Any, context: Any) -> None:
        path = getattr(group, name)
        absolute = path.strip()
        is_path = not (of_library and (is_server_address(absolute) or is_database_address(absolute)))
        if of_library:
            absolute = keep_password(absolute)
        if path and is_path:
            absolute = os.path.abspath(bpy.path.abspath(path))  # noqa: PTH100 - keeps links
        if path != absolute:
            setattr(group, name, absolute)  # which calls this again
        elif of_library and hasattr(context.window_manager, "shape_google"):
            from .library.present import library_changed

            library_changed(context)

    return update


def _listed_numbers(group: Any, _context: Any) -> None:
    """Keep the whole numbers of the frames, in order and each once."""
    numbers = ",".join(map(str, sorted(set(map(int, re.findall(r"-?\d+", group.frames))))))
    if group.frames != numbers:
        group.frames = numbers  # which calls this again


def _changed(_group: Any, context: Any) -> None:
    # Blender does not notice by itself that something inside a list was changed.
    context.preferences.is_dirty = True


def _draw_shortcut(column: Any, context: Any) -> None:
    """Show the key of *Find Similar*, to be changed."""
    import rna_keymap_ui

    keys = context.window_manager.keyconfigs.user
    keymap = None if keys is None else keys.keymaps.get("3D View")
    for entry in [] if keymap is None else keymap.keymap_items:
        if entry.idname == "shape_google.find_similar":
            column.context_pointer_set("keymap", keymap)
            rna_keymap_ui.draw_kmi([], keys, keymap, entry, column, 0)


class SHAPEGOOGLE_PG_folder(bpy.types.PropertyGroup):
    """A folder whose shapes are indexed."""

    path: StringProperty(
        name="Folder",
        description="Searched with all folders below it",
        subtype="DIR_PATH",
        maxlen=1024,
        update=_absolute("path"),
    )
    use: BoolProperty(
        name="Index", description="Take this folder into the library", default=True, update=_changed
    )


class SHAPEGOOGLE_preferences(ServerPreferences, bpy.types.AddonPreferences):
    """Preferences of the add-on."""

    bl_idname = __package__

    library: StringProperty(
        name="Library",
        description=(
            "File that stores the signatures of all shapes, created when you first index into it; or the "
            "address of a server or a database, such as https://shapes.example"
        ),
        subtype="FILE_PATH",
        maxlen=1024,
        update=_absolute("library", of_library=True),
    )
    folder: StringProperty(
        name="Libraries Folder",
        description="Folder for new libraries; if empty, Blender's own folder for this extension",
        subtype="DIR_PATH",
        maxlen=1024,
        update=_absolute("folder", of_library=True),
    )
    folders: CollectionProperty(type=SHAPEGOOGLE_PG_folder)
    active_folder: IntProperty(name="Folder", options={"SKIP_SAVE"})
    use_asset_libraries: BoolProperty(
        name="Asset Libraries", description="Index the asset libraries of Blender's preferences", default=True
    )
    use_scene: BoolProperty(
        name="This Scene",
        description="Index the objects of the open scene as they are now, saved or not",
        default=False,
    )
    objects: EnumProperty(
        name="Objects", description="Which objects of a .blend file are shapes", items=_OBJECTS
    )
    frames: StringProperty(
        name="Frames",
        description=(
            "Frames of animated .blend files, such as 1,10,20: each pose of an object is a shape of its own. "
            "If empty, the frame that the file was saved at"
        ),
        update=_listed_numbers,
    )
    jobs: IntProperty(
        name="Workers",
        description="Number of processes that describe shapes; 0: one for each processor",
        default=0,
        min=0,
        max=256,
    )
    time_limit: IntProperty(
        name="Time Limit",
        description=(
            "Seconds without progress in reading one file, and to describe one shape; slower files are "
            "skipped and listed"
        ),
        default=300,
        min=1,
        max=86_400,
    )
    memory_limit: IntProperty(
        name="Memory Limit",
        description="Megabytes to read one file, and to describe one shape; enforced on Linux only",
        default=4096,
        min=256,
        max=1_048_576,
    )
    author: StringProperty(
        name="Author",
        description="Your name in decisions; if empty, that of your account on this computer",
        maxlen=200,
        update=_changed,
    )
    model: EnumProperty(
        name="Model",
        description="Model of a new library; a library keeps the model that it was created with",
        items=_MODELS,
    )
    model_file: StringProperty(
        name="Model File",
        description="A file made by Train Model",
        subtype="FILE_PATH",
        maxlen=1024,
        update=_absolute("model_file"),
    )

    def draw(self, context: Any) -> None:
        """Lay the preferences out."""
        layout = self.layout
        missing = needs.sentence()
        if missing:
            needs.draw_sentence(layout, missing, letters=80)
            return
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.operator("shape_google.open_manual", icon="HELP")
        column = layout.column(heading="Library")
        column.prop(self, "library", placeholder=self.library_path().name)
        column.prop(self, "folder", placeholder="Blender's own folder for extensions")
        self.draw_server(layout)
        column = layout.column(heading="Decisions")
        column.prop(self, "author", placeholder=login_name())
        column = layout.column(heading="Indexing")
        column.prop(self, "jobs", text="Workers (0: All Processors)")
        column.prop(self, "time_limit", text="Time Limit (s)")
        column.prop(self, "memory_limit", text="Memory Limit (MB)")
        _draw_shortcut(layout.column(heading="Shortcut"), context)
        column = layout.column(heading="Model")
        column.prop(self, "model")
        row = column.row()
        row.enabled = self.model == "FILE"
        row.prop(self, "model_file")
        # Below the fields, not below their names.
        split = column.split(factor=0.4)
        split.separator()
        column = split.column()
        row = column.row(align=True)
        row.operator("shape_google.train_model", icon="FILE_REFRESH")
        row.operator("shape_google.cancel_training", text="", icon="X")
        column.label(text=context.window_manager.shape_google.training)

    def library_path(self) -> Path:
        """Return the library file: the chosen one, or the one in the libraries' folder."""
        if self.library:
            return Path(self.library)
        return self.libraries_folder() / f"shapes{LIBRARY_SUFFIX}"

    def libraries_folder(self) -> Path:
        """Return the folder for new libraries, which need not exist yet."""
        if self.folder:
            return Path(self.folder)
        return user_folder("libraries")

    def model_name(self) -> str:
        """Return the name or path of the chosen model, as `shapegoogle_core.load_model` takes it."""
        return str(self.model_file) if self.model == "FILE" else str(self.model).lower()

    def author_name(self) -> str:
        """Return the name that decisions are made under."""
        return str(self.author).strip() or login_name()

    def has_sources(self) -> bool:
        """Whether any source of files is chosen; does not access the disk."""
        libraries = self.use_asset_libraries and bool(connections.asset_libraries())
        return libraries or any(item.use and item.path for item in self.folders)

    def sources(self) -> Sequence[Path]:
        """Return the folders that are indexed: asset libraries that exist, then added folders."""
        libraries = connections.asset_libraries() if self.use_asset_libraries else []
        # Blender lists a library of its own from the start, whose folder rarely exists.
        chosen = [path for _, path in libraries if path.is_dir()]
        chosen += [Path(item.path) for item in self.folders if item.use and item.path]
        return list(dict.fromkeys(chosen))


@cache
def login_name() -> str:
    """Return the name of the user's account; empty where the system does not know it."""
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # such as a container without accounts
        return ""


def preferences(context: Any | None = None) -> SHAPEGOOGLE_preferences:
    """Return the add-on's preferences.

    Parameters
    ----------
    context : bpy.types.Context, optional

    Returns
    -------
    preferences : SHAPEGOOGLE_preferences
    """
    addon = (context or bpy.context).preferences.addons[__package__]
    chosen: SHAPEGOOGLE_preferences = addon.preferences
    return chosen


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_folder, SHAPEGOOGLE_preferences))
