# SPDX-License-Identifier: GPL-3.0-or-later
"""Work beside Blender's window: one worker process for quick answers, a background Blender for long runs.

Only the main thread may touch bpy. A worker process runs the core alone, under the Python that Blender
brings; `watch` hands its results to the main thread. `BackgroundRun` is the add-on's command in another
Blender.
"""

from __future__ import annotations

import json
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, TypeVar

import bpy

from . import connections, state

if TYPE_CHECKING:
    from shapegoogle_core.processes.worker import Worker

__all__ = ["BackgroundRun", "end", "redraw", "stop_all", "watch", "worker"]

T = TypeVar("T")

# How often the main thread looks for results, in seconds; nothing is drawn for a look.
INTERVAL = 0.02
# How long a background Blender may take to end by itself after it was asked to.
PATIENCE = 5.0
KEPT_LINES = 100
# How the command's own errors begin.
SAID = "shapegoogle: "


def worker() -> Worker:
    """Return the worker process of this Blender, which starts at its first task."""
    from shapegoogle_core.processes.worker import Worker

    processes = state.current().jobs
    if processes.worker is None:
        processes.worker = Worker()
    return processes.worker


def watch(future: Future[T], done: Callable[[T], None], failed: Callable[[BaseException], None]) -> None:
    """Have the main thread take a result when it is there.

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
        try:
            result = future.result()
        except CancelledError:
            pass  # whoever cancelled knows
        except Exception as error:
            failed(error)
        else:
            done(result)
        redraw()
        return None

    bpy.app.timers.register(look, first_interval=INTERVAL, persistent=True)


def redraw() -> None:
    """Have all 3D views drawn again: the sidebar shows results and progress."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


class BackgroundRun:
    """The add-on's command in another process, watched through its ``--events``.

    Parameters
    ----------
    arguments : sequence of str
        As for `commands.main`.

    Attributes
    ----------
    lines : deque of str
        The last lines that it printed and that were no events.
    exit_code : int or None
        None while it runs.
    reported : bool
        For whoever takes the events: whether the last one, which sums all up, was among them.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        command, environment = connections.package_command(arguments)
        self.lines: deque[str] = deque(maxlen=KEPT_LINES)
        self.exit_code: int | None = None
        self.reported = False
        self._started = time.monotonic()
        self._events: SimpleQueue[dict[str, Any]] = SimpleQueue()
        from shapegoogle_core.processes.launching import NO_WINDOW

        self._process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
            creationflags=NO_WINDOW,
            env=environment,
        )
        state.current().jobs.runs.append(self)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            if line.startswith("{"):
                with suppress(ValueError):  # a line that only looks like one of ours
                    self._events.put(json.loads(line))
                    continue
            self.lines.append(line.rstrip())

    def events(self) -> list[dict[str, Any]]:
        """Take the events that came in since the last call; sets `exit_code` after the last one."""
        ended = not self._reader.is_alive()
        events = []
        with suppress(Empty):
            while True:
                events.append(self._events.get_nowait())
        if ended and self.exit_code is None:
            self.exit_code = self._process.wait()
            state.current().jobs.runs.remove(self)
        return events

    def seconds(self) -> float:
        """Return for how long it has been running."""
        return time.monotonic() - self._started

    def last_words(self) -> str:
        """Return why it ended: what the command said, or else the last that was printed."""
        said = [line for line in self.lines if line.startswith(SAID)]
        if said:
            return said[-1].removeprefix(SAID)
        return "; ".join(line for line in list(self.lines)[-3:] if line) or f"exit code {self.exit_code}"

    def join(self) -> None:
        """Wait until it has ended; take its `events` then."""
        self._reader.join()

    def cancel(self) -> None:
        """End it. What it had stored stays: each file is one transaction."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                self._process.kill()


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
    processes = state.current().jobs
    end(processes.runs)
    if processes.worker is not None:
        processes.worker.stop()
        processes.worker = None
    state.current().library.warm.clear()
