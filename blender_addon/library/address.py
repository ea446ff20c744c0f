# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the chosen library lies, and whether it may be searched: a file, or a service on a server."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from .. import state
from ..preferences import preferences
from ..server import is_database_address, is_server_address, user_folder
from ..translation import marked, tr

if TYPE_CHECKING:
    from shapegoogle_core.client import LibraryAddress

__all__ = [
    "NEEDS_FILE",
    "is_on_server",
    "is_there",
    "library_address",
    "library_key",
    "library_missing",
    "refusal",
]

NEEDS_FILE = marked(
    "This library is on a server: shapes are added, moved and removed there, with the command shapegoogle"
)
"""Why a library on a server cannot be changed here."""


def library_key(context: Any) -> str:
    """Return the text that the chosen library is known by: its path, or the address of its server.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    key : str
    """
    chosen = preferences(context)
    return str(chosen.library if is_on_server(context) else chosen.library_path())


def is_on_server(context: Any) -> bool:
    """Whether the library is on a server, or in a database, and so no file.

    Parameters
    ----------
    context : bpy.types.Context
    """
    place = preferences(context).library
    return is_server_address(place) or is_database_address(place)


def library_address(context: Any) -> LibraryAddress:
    """Return the address of the chosen library, for requests to the worker process.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    address : LibraryAddress
        Where the library must not be opened, such as while Blender is offline, it says why, and the worker
        answers each request with that.
    """
    from shapegoogle_core.client import LibraryAddress

    chosen = preferences(context)
    if not is_on_server(context):
        return LibraryAddress(chosen.library_path(), chosen.root_folders())
    is_database = is_database_address(chosen.library)
    return LibraryAddress(
        chosen.library,
        chosen.root_folders(),
        token="" if is_database else chosen.token,
        password=chosen.token if is_database else "",
        certificate=bpy.path.abspath(chosen.certificate) if chosen.certificate else "",
        cache=str(user_folder("models")),
        refusal=refusal(context),
    )


def refusal(context: Any) -> str:
    """Say why nothing is asked of a library on a server; cheap enough for a panel.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    sentence : str
        Empty if it may be asked, and for a file.
    """
    chosen = preferences(context)
    if not is_on_server(context):
        return ""
    if not chosen.allow_network:
        return tr("Turn on Search on a Server in the add-on's preferences; its tooltip says what is sent")
    if not bpy.app.online_access:
        return tr("Blender is offline: turn on Allow Online Access in its preferences, under System")
    return ""


def is_there(context: Any) -> bool:
    """Whether the file of the library exists; cheap enough for an operator's poll.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    is_there : bool
        As it was at the last look, where there is a window. Before the first one, that it is: whoever opens
        it says if it is not. The same holds for a library on a server.
    """
    if is_on_server(context):
        return True
    library = state.current().library
    return library.file != () if library.followed else preferences(context).library_path().is_file()


def library_missing(context: Any) -> str:
    """Say why the library cannot be searched; cheap enough for an operator's poll.

    Parameters
    ----------
    context : bpy.types.Context

    Returns
    -------
    sentence : str
        Empty if it can.
    """
    return refusal(context) or ("" if is_there(context) else tr("Index a library first"))
