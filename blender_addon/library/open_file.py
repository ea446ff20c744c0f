# SPDX-License-Identifier: GPL-3.0-or-later
"""The open file as a source of the library.

A .blend file is one source, open or not: its path. The shapes of an open file are replaced by those of the
scene when that is indexed, and by those on the disk when the file is. A file that has never been saved has
no path: it has a name of its own until it is saved or another file is opened, and its shapes then become
those of the saved file. The name is kept in the memory of the add-on: in the file, undo could take it away,
and copies of the file would share it.
"""

from __future__ import annotations

import os
import uuid
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent

from .. import jobs, state
from ..state import session_of
from ..translation import tr

if TYPE_CHECKING:
    from shapegoogle_core.processes.worker import Worker

__all__ = [
    "UNSAVED",
    "is_open_file",
    "is_unsaved",
    "open_source",
    "register",
    "shown_file",
    "take_over",
    "unregister",
]

UNSAVED = "Unsaved file "
"""How the sources of files that have never been saved begin."""


def open_source() -> str:
    """Return the source that the open file is: its path, or its own name until it is saved."""
    if bpy.data.filepath:
        return str(bpy.data.filepath)
    library = state.current().library
    library.unsaved_name = library.unsaved_name or f"{UNSAVED}{uuid.uuid4().hex[:8]}"
    return library.unsaved_name


def is_unsaved(source: str) -> bool:
    """Whether a source is a file that had never been saved when it was indexed."""
    return source.startswith(UNSAVED)


def shown_file(source: str) -> str:
    """Return the path that is shown for a source: one that was never saved has none, but words."""
    return tr("unsaved file") if is_unsaved(source) else source


def is_open_file(source: str) -> bool:
    """Whether a source of the library is the open file, however its path is spelt."""
    here = open_source()
    if source == here:
        return True
    if is_unsaved(source) or is_unsaved(here):
        return False
    paths = [os.path.normcase(path) for path in (source, here)]
    return Path(paths[0]).name == Path(paths[1]).name and (
        os.path.realpath(paths[0]) == os.path.realpath(paths[1])
    )


def take_over(worker: Worker | None = None) -> None:
    """Have the shapes of a file that has been saved for the first time become those of the saved file.

    A worker process writes the libraries; without a window it is waited for. Libraries that cannot be written
    at the moment are tried again when the scene is next indexed.

    Parameters
    ----------
    worker : Worker, optional
        By default that of `jobs.worker`.
    """
    from shapegoogle_core import ShapeGoogleError
    from shapegoogle_core.worker.scene import rename_source

    renamed = state.current().library.renamed
    for entry in list(renamed):
        future = (worker or jobs.worker()).submit(rename_source, *entry)
        if bpy.app.background:
            with suppress(ShapeGoogleError):  # then it stays in the list
                future.result()
                renamed.remove(entry)
        else:
            jobs.complete(future)
            jobs.watch(future, partial(_is_renamed, entry), _stays)


def _is_renamed(entry: tuple[Path, str, str], _result: None) -> None:
    renamed = state.current().library.renamed
    if entry in renamed:
        renamed.remove(entry)


def _stays(_error: BaseException) -> None:
    """Leave the library in the list of those in which the source has its first name."""


@persistent
def _note_saved(*_arguments: Any) -> None:
    """After saving: an unsaved file has a path now; a copy saved elsewhere changes nothing."""
    library = state.current().library
    old, new = library.unsaved_name, str(bpy.data.filepath)
    if not (old and new):
        return
    library.unsaved_name = ""
    library.renamed += [(path, old, new) for path in sorted(library.unsaved_in)]
    library.unsaved_in.clear()
    library.objects = {
        (new if source == old else source, name): uid for (source, name), uid in library.objects.items()
    }
    session = session_of(bpy.context)
    for line in (*session.matches, *session.versions, *session.examples):
        if line.source == old:
            line.source = new
    take_over()


@persistent
def _note_opened(*_arguments: Any) -> None:
    """Another file is open: one without a path is a new file, which gets a name of its own."""
    library = state.current().library
    library.opened += 1
    library.unsaved_name = ""
    library.unsaved_in.clear()
    library.objects.clear()


def register() -> None:
    """Register the handlers."""
    bpy.app.handlers.save_post.append(_note_saved)
    # Before the handlers that look for the objects of matches.
    bpy.app.handlers.load_post.insert(0, _note_opened)


def unregister() -> None:
    """Unregister the handlers."""
    bpy.app.handlers.load_post.remove(_note_opened)
    bpy.app.handlers.save_post.remove(_note_saved)
