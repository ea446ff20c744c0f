# SPDX-License-Identifier: GPL-3.0-or-later
"""Preferences of libraries on a server: consent, token, certificate; and the folders that roots are here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, IntProperty, StringProperty

from . import state
from .translation import marked, tr

__all__ = [
    "ServerPreferences",
    "is_database_address",
    "is_server_address",
    "keep_password",
    "register",
    "unregister",
    "user_folder",
]

# As `shapegoogle_core.library.storage.address`, which drawing must not import; a test compares them.
_SERVICES = ("https://", "http://")
_DATABASES = ("postgresql://", "postgres://")

WHAT_IS_SENT = marked(
    "Find Similar and Suggest Tags send the signature of the selected shapes to the server in Library: "
    "numbers and 600 points of the surface, not the mesh. Filters, examples and decisions are sent too. "
    "Nothing is sent while this is off, or while Blender is offline"
)


def is_server_address(place: str) -> bool:
    """Whether a library is named by the address of a service."""
    return place.lower().startswith(_SERVICES)


def is_database_address(place: str) -> bool:
    """Whether a library is named by the address of a database."""
    return place.lower().startswith(_DATABASES)


def keep_password(place: str) -> str:
    """Keep the password in the address of a database where tokens are kept, and return the rest.

    Parameters
    ----------
    place : str
        Any place of a library.

    Returns
    -------
    place : str
    """
    if not is_database_address(place):
        return place
    from shapegoogle_core.library.storage.address import split_password

    place, password = split_password(place)
    if password:
        _keep(place, password)
    return place


def user_folder(name: str) -> Path:
    """Return a folder for files of the add-on, which need not exist yet: nowhere beside its code.

    Parameters
    ----------
    name : str
        Of the folder.

    Returns
    -------
    folder : Path
    """
    try:
        return Path(bpy.utils.extension_path_user(__package__, path=name))
    except ValueError:  # this package is no extension, but a folder on Python's path
        path = "shape_google" if name == "libraries" else f"shape_google/{name}"
        return Path(bpy.utils.user_resource("DATAFILES", path=path))


def _tokens() -> Any:
    from shapegoogle_core.client import KeptTokens

    return KeptTokens(user_folder("server") / "tokens.json")


def _token(group: Any) -> str:
    """Return the token for the server, which is not kept in Blender's preferences: these are often copied."""
    kept = state.current().library.tokens
    if group.library not in kept:
        kept[group.library] = _tokens().token(group.library)
    return str(kept[group.library])


def _keep_token(group: Any, text: str) -> None:
    _keep(group.library, text)


def _keep(place: str, text: str) -> None:
    from shapegoogle_core import LibraryError

    try:
        _tokens().keep(place, text)
    except LibraryError as error:
        # A property cannot report; the token is known until Blender ends.
        print(f"shapegoogle: {error}")
    state.current().library.tokens[place] = text.strip()


def _look_again(_group: Any, context: Any) -> None:
    context.preferences.is_dirty = True
    if hasattr(context.window_manager, "shape_google"):
        from .library.present import look_again

        look_again(context)


class SHAPEGOOGLE_PG_root(bpy.types.PropertyGroup):
    """A root of libraries and the folder that it is on this computer."""

    name: StringProperty(name="Root", description="Name of the root in the library", update=_look_again)
    path: StringProperty(
        name="Folder",
        description="Folder that the root is on this computer",
        subtype="DIR_PATH",
        maxlen=1024,
        update=_look_again,
    )


class ServerPreferences:
    """Part of the preferences: libraries on a server, and roots."""

    allow_network: BoolProperty(
        name="Search on a Server", description=WHAT_IS_SENT, default=False, update=_look_again
    )
    token: StringProperty(
        name="Token",
        description=(
            "Of the server in Library, from whoever runs it; of a database the password. It is kept in a "
            "file of the add-on that only you may read, not in Blender's preferences"
        ),
        subtype="PASSWORD",
        maxlen=200,
        get=_token,
        set=_keep_token,
    )
    certificate: StringProperty(
        name="Certificate",
        description="File with the certificate of the server, if no authority has signed it",
        subtype="FILE_PATH",
        maxlen=1024,
        update=_look_again,
    )
    roots: CollectionProperty(type=SHAPEGOOGLE_PG_root)
    active_root: IntProperty(name="Root", options={"SKIP_SAVE"})

    def root_folders(self) -> tuple[tuple[str, str], ...]:
        """Return the names of roots and the folders that they are on this computer."""
        return tuple(
            (root.name.strip(), bpy.path.abspath(root.path))
            for root in self.roots
            if root.name.strip() and root.path
        )

    def draw_server(self: Any, layout: Any) -> None:
        """Lay this part out."""
        column = layout.column(heading="Server")
        column.prop(self, "allow_network")
        if self.allow_network and not bpy.app.online_access:
            column.label(text="Blender is offline; Allow Online Access is in its preferences, under System")
        column = column.column()
        is_database = is_database_address(self.library)
        column.enabled = is_database or is_server_address(self.library)
        column.prop(self, "token", text=tr("Password") if is_database else tr("Token"), translate=False)
        if not is_database:  # its address names it: ?sslrootcert=
            column.prop(self, "certificate")
        # Below the fields, not below their names.
        split = layout.split(factor=0.4)
        label = split.row()
        label.alignment = "RIGHT"
        label.label(text=tr("Folders of Roots"))
        row = split.row()
        row.use_property_split = False
        row.template_list("SHAPEGOOGLE_UL_roots", "", self, "roots", self, "active_root", rows=2, maxrows=4)
        buttons = row.column(align=True)
        buttons.operator("shape_google.add_root", text="", icon="ADD")
        buttons.operator("shape_google.remove_root", text="", icon="REMOVE")


class SHAPEGOOGLE_UL_roots(bpy.types.UIList):
    """Roots and their folders."""

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
        """Lay a root out."""
        split = layout.split(factor=0.35)
        split.prop(item, "name", text="", emboss=False)
        split.prop(item, "path", text="")


register, unregister = bpy.utils.register_classes_factory((SHAPEGOOGLE_PG_root, SHAPEGOOGLE_UL_roots))
