# SPDX-License-Identifier: GPL-3.0-or-later
"""Another file has other objects: the answer to a query in the file before is cleared.

Not after *Open File*, which opens the file of a match to go on with it there, and not if the same file is
read again.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.app.handlers import persistent

from .. import state
from .answer import drop_answer

__all__ = ["register", "unregister"]


@persistent
def _note_before(*_arguments: Any) -> None:
    state.current().search.file_before = bpy.data.filepath


@persistent
def _clear(*_arguments: Any) -> None:
    search = state.current().search
    kept = [search.file_before, search.file_wanted]
    search.file_before = search.file_wanted = ""
    if not any(_is_open(path) for path in kept if path):
        drop_answer(bpy.context, "")


def _is_open(path: str) -> bool:
    return bool(bpy.data.filepath) and Path(path).resolve() == Path(bpy.data.filepath).resolve()


def register() -> None:
    """Clear the answer from now on."""
    bpy.app.handlers.load_pre.append(_note_before)
    bpy.app.handlers.load_post.append(_clear)


def unregister() -> None:
    """Do so no more."""
    bpy.app.handlers.load_post.remove(_clear)
    bpy.app.handlers.load_pre.remove(_note_before)
