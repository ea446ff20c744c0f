# SPDX-License-Identifier: GPL-3.0-or-later
"""The library that is chosen at present: what is shown of it, kept up to date.

The library changes without the add-on's doing: other programs index into it, replace it or delete it, and the
preferences can name another one. Whatever is shown of it, such as matches, examples and counts, is refreshed
here, or goes with it.

The file may be on a network drive that answers slowly or never, so that the window must not wait for it: all
looks at the file are made in other threads.
"""

from __future__ import annotations

import importlib
import os
import threading
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

import bpy

from .. import jobs, state
from ..preferences import preferences
from ..state import session_of
from ..translation import error_text, marked, tr
from .address import is_on_server, is_there, library_address, library_key

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core.worker.library_state import LibraryState

__all__ = [
    "follow",
    "is_there",
    "library_changed",
    "look_again",
    "refresh",
    "when_it_changes",
    "when_it_goes",
]

T = TypeVar("T")

# A look is made at one tick and compared at the next.
SECONDS_BETWEEN_LOOKS = 1.0

# What has happened to a match since the search.
NO_LONGER_INDEXED = marked("No longer indexed")
INDEXED_AGAIN = marked("Indexed again since")


def follow(context: Any) -> None:
    """Keep an eye on the library from now on; cheap enough for a panel's draw.

    Whoever looks at a panel is about to query the library, or to paint: the worker process opens it.

    Parameters
    ----------
    context : bpy.types.Context
    """
    library = state.current().library
    if library.followed or bpy.app.background:
        return
    library.followed = True
    library.shown = library_key(context)

    def begin(tasks: ModuleType) -> None:
        jobs.worker().submit(tasks.warm_up)
        refresh(bpy.context)
        bpy.app.timers.register(_look, first_interval=SECONDS_BETWEEN_LOOKS, persistent=True)

    # The core is imported in another thread, since the import would block the window for half a second.
    jobs.watch(_import_core(), begin, _leave_to_query)


def library_changed(context: Any) -> None:
    """Drop what belongs to another library, once the preferences name a new one.

    Parameters
    ----------
    context : bpy.types.Context
    """
    key = library_key(context)
    library, session = state.current().library, session_of(context)
    if library.shown == key:
        return
    library.shown, library.file, library.look = key, None, None
    session.connection = ""
    session.roots.clear()
    session.shape_count, session.without_views, session.model = 0, 0, ""
    if not session.indexing:
        session.summary = ""
        session.errors.clear()
    for forget in library.forget:
        forget(context, "")
    if library.followed:
        refresh(context)


def look_again(context: Any) -> None:
    """Look at the library again: it may be reachable now, or no longer, or other folders are its roots.

    Parameters
    ----------
    context : bpy.types.Context
    """
    session_of(context).connection = ""
    if state.current().library.followed:
        refresh(context)


def refresh(context: Any) -> None:
    """Count the shapes of the library again, and find out which of those shown are still in it.

    Parameters
    ----------
    context : bpy.types.Context
    """
    if bpy.app.background and state.current().jobs.worker is None:
        return  # nobody is looking
    from shapegoogle_core.worker.library_state import ShownShape
    from shapegoogle_core.worker.requests import library_state

    address, session = library_address(context), session_of(context)
    if address.refusal:
        return
    lines = (*session.matches, *session.versions)
    shown = [(line.shape_id, line.source, line.name) for line in lines]
    shown += [
        (example.shape_id, example.source, example.shape_name)
        for example in session.examples
        if example.library == str(address.place)
    ]
    shapes = [ShownShape(*shape) for shape in dict.fromkeys(shown)]
    jobs.watch(jobs.worker().submit(library_state, address, shapes), _show, _failed)


def _show(found: LibraryState) -> None:
    """Show what the worker has found, unless another library has been chosen meanwhile."""
    context = bpy.context
    if library_address(context) != found.library:
        return
    session = session_of(context)
    session.connection = ""
    session.roots.clear()
    for root in found.roots:
        line = session.roots.add()
        line.name, line.path = root.name, root.path
    if found.model_file:
        state.current().library.service_model = str(found.library.place), found.model_file
    session.shape_count, session.model = found.shape_count, found.model
    session.without_views = found.without_views
    for match in (*session.matches, *session.versions):
        today = found.today.get(match.shape_id, match.shape_id)
        same = today == match.shape_id
        match.since = "" if same else NO_LONGER_INDEXED if today is None else INDEXED_AGAIN
    for example in session.examples:
        if example.library == str(found.library.place):
            today = found.today.get(example.shape_id, example.shape_id)
            example.is_gone = today is None
            example.shape_id = example.shape_id if today is None else today
    for notice in state.current().library.notice:
        notice(context)


def _look() -> float | None:
    """Notice that the preferences name another library, or that its file was written, replaced or deleted."""
    if not state.is_registered():
        return None
    context = bpy.context
    library = state.current().library
    if library.shown != library_key(context):
        library_changed(context)
    if is_on_server(context):
        return SECONDS_BETWEEN_LOOKS
    path = preferences(context).library_path()
    if library.look is None:
        library.look = _in_thread(lambda: _file(path))
    elif library.look.done():
        found, library.look = library.look.result(), None
        if found is not None:
            _compare(context, path, found)
    return SECONDS_BETWEEN_LOOKS


def _compare(context: Any, path: Path, now: tuple[int, ...]) -> None:
    """Show what has become of the library's file since the last look."""
    library = state.current().library
    before, library.file = library.file, now
    if before != now == ():  # choosing sources is the next step
        session_of(context).show_sources = True
        jobs.redraw()
    if before in (None, now):
        return
    if before and now[:2] != before[:2]:
        template = (
            tr("The library {name} was replaced by another file")
            if now
            else tr("The library {name} is no longer there")
        )
        for forget in library.forget:
            forget(context, template.format(name=path.name))
    refresh(context)
    jobs.redraw()


def _file(path: Path) -> tuple[int, ...] | None:
    """Look at a file: its device and number, and when it or its journal was written.

    Empty if there is none; None if that cannot be found out.
    """
    try:
        status = os.stat(path)  # noqa: PTH116 - as the line below
        journal = path.with_name(f"{path.name}-wal")
        written = journal.stat().st_mtime_ns if journal.exists() else 0
    except (FileNotFoundError, NotADirectoryError):
        return ()
    except OSError:
        return None
    return status.st_dev, status.st_ino, status.st_mtime_ns, written


def _failed(error: BaseException) -> None:
    """Show what is wrong with a server; the error of a file is left to the next query."""
    if is_on_server(bpy.context):
        session_of(bpy.context).connection = error_text(error)


def _leave_to_query(_error: BaseException) -> None:
    """Leave it to the next query to report the error."""


def _import_core() -> Future[ModuleType]:
    """Import in another thread the functions that tasks are sent with; numpy comes along."""
    return _in_thread(lambda: importlib.import_module("shapegoogle_core.worker.requests"))


def _in_thread(function: Callable[[], T]) -> Future[T]:
    """Call a function in another thread, for which Blender does not wait when it ends."""
    from concurrent.futures import Future

    future: Future[T] = Future()

    def call() -> None:
        try:
            result = function()
        except Exception as error:
            future.set_exception(error)
        else:
            future.set_result(result)

    threading.Thread(target=call, daemon=True).start()
    return future


def when_it_changes(notice: Callable[[Any], None]) -> None:
    """Have a feature look at the library again when it has changed, or another one was chosen.

    Parameters
    ----------
    notice : callable
        Called with the context.
    """
    state.current().library.notice.append(notice)


def when_it_goes(forget: Callable[[Any, str], None]) -> None:
    """Have a feature drop its results when the library is no longer the one that they are from.

    Parameters
    ----------
    forget : callable
        Called with the context, and with a sentence to show in place of the results; empty for none.
    """
    state.current().library.forget.append(forget)
