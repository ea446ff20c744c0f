# SPDX-License-Identifier: GPL-3.0-or-later
"""Work outside Blender's window: a worker process for short tasks, background commands for long runs.

Only the main thread may touch bpy. A worker process runs the core alone, under the Python that Blender
brings; `watch` hands its results to the main thread. `BackgroundRun` is the add-on's command in another
Blender.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, TypeVar

import bpy

from . import connections, state
from .translation import tr

if TYPE_CHECKING:
    from concurrent.futures import Future

    from shapegoogle_core.cli.events import Event
    from shapegoogle_core.processes.worker import Worker

__all__ = ["BackgroundRun", "complete", "end", "redraw", "shows_matches", "stop_all", "watch", "worker"]

T = TypeVar("T")

# Seconds that tasks may take that have to be completed when Blender ends.
PATIENCE = 10.0
# Seconds between the main thread's checks for results, which draw nothing.
INTERVAL = 0.01
# Of the sidebar, the tab that has the add-on's panels.
CATEGORY = "Shape Google"
# Kind of node tree by which an area is a gallery, see `gallery.editor.area`.
GALLERY = "SHAPEGOOGLE_NT_gallery"


def worker() -> Worker:
    """Return the worker process of this Blender, which starts at its first task."""
    from shapegoogle_core.processes.worker import Worker

    processes = state.current().jobs
    if processes.worker is None:
        processes.worker = Worker()
    return processes.worker


def watch(future: Future[T], done: Callable[[T], None], failed: Callable[[BaseException], None]) -> None:
    """Have the main thread take a result when it is ready.

    Parameters
    ----------
    future : Future
    done : callable
        Called with the result.
    failed : callable
        Called with the error; not for a task that was cancelled.
    """

    def look() -> float | None:
        if not state.is_registered():
            return None
        if not future.done():
            return INTERVAL
        if not future.cancelled():  # else the caller that cancelled it has shown that
            try:
                result = future.result()
            except Exception as error:
                failed(error)
            else:
                done(result)
        redraw()
        return None

    bpy.app.timers.register(look, first_interval=INTERVAL, persistent=True)


def complete(future: Future[Any]) -> None:
    """Have the end of Blender wait for a task, for some seconds at most: what it does would be lost.

    Parameters
    ----------
    future : Future
    """
    waiting = state.current().jobs.to_complete
    waiting.append(future)
    future.add_done_callback(waiting.remove)


def redraw() -> None:
    """Have preferences, galleries and the sidebars with the add-on's tab drawn again; never the 3D views."""
    for sidebar in _sidebars():
        sidebar.tag_redraw()
    for area in _areas():
        if area.type == "PREFERENCES" or _is_gallery(area):
            area.tag_redraw()


def shows_matches() -> bool:
    """Whether a gallery or a sidebar with the add-on's tab is open in some window."""
    return any(True for _ in _sidebars()) or any(map(_is_gallery, _areas()))


def _areas() -> Iterator[Any]:
    return (area for window in bpy.context.window_manager.windows for area in window.screen.areas)


def _is_gallery(area: Any) -> bool:
    return bool(area.type == "NODE_EDITOR" and area.spaces.active.tree_type == GALLERY)


def _sidebars() -> Iterator[Any]:
    """Regions that show the add-on's tab."""
    for area in _areas():
        if area.type == "VIEW_3D" and area.spaces.active.show_region_ui:
            for region in area.regions:
                if region.type == "UI" and region.active_panel_category == CATEGORY:
                    yield region


class BackgroundRun:
    """The add-on's command in another process, watched through its events.

    Parameters
    ----------
    arguments : sequence of str
        As for `commands.main`.

    Attributes
    ----------
    exit_code : int or None
        None while it runs.
    reported : bool
        For the caller that takes the events: whether the last one, the summary, was among them.

    Raises
    ------
    OSError
        If the process cannot be started.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        from shapegoogle_core.processes.program import Program

        command, environment = connections.package_command(arguments)
        self.exit_code: int | None = None
        self.reported = False
        self._error = ""
        self._events: SimpleQueue[Event] = SimpleQueue()
        self._program = Program(command, environment=environment)
        state.current().jobs.runs.append(self)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        from shapegoogle_core.cli.events import event_from_json

        for message in self._program.messages():
            self._events.put(event_from_json(message))
        self._program.wait()

    def events(self) -> list[Event]:
        """Take the events since the last call; sets `exit_code` after the last one."""
        from shapegoogle_core.cli.events import CommandError

        ended = not self._reader.is_alive()
        events: list[Event] = []
        with suppress(Empty):
            while True:
                event = self._events.get_nowait()
                if isinstance(event, CommandError):
                    self._error = event.reason
                else:
                    events.append(event)
        if ended and self.exit_code is None:
            self.exit_code = self._program.wait()
            state.current().jobs.runs.remove(self)
        return events

    def last_words(self) -> str:
        """Return why it ended: the error that the command reported, or how its process ended."""
        text = tr("the process has ended unexpectedly ({ending}); try it again")
        return self._error or text.format(ending=self._program.ending(3))

    def join(self) -> None:
        """Wait until it has ended; take its `events` then."""
        self._reader.join()

    def cancel(self) -> None:
        """End it. The shapes it has stored stay: each file is one transaction."""
        self._program.terminate()


def end(runs: list[Any]) -> None:
    """Cancel runs, wait until they have ended, and take them out of their list.

    Parameters
    ----------
    runs : list of BackgroundRun or SceneIndexing
    """
    for run in list(runs):
        run.cancel()
        run.join()
        run.events()
    runs.clear()


def stop_all() -> None:
    """End all background work."""
    from concurrent.futures import wait

    processes = state.current().jobs
    wait(list(processes.to_complete), PATIENCE)
    end(processes.runs)
    if processes.worker is not None:
        processes.worker.stop()
        processes.worker = None
