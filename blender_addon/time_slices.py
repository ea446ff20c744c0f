# SPDX-License-Identifier: GPL-3.0-or-later
"""`InSlices`: work on Blender's own data in short slices; the window shows progress and can cancel.

Only the main thread may touch bpy, so such work cannot go to another process. Arithmetic with large arrays in
between can go to another thread: see `aside`.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future
from typing import Any, TypeVar

from . import jobs

__all__ = ["InSlices", "aside", "next_slice", "result_of"]

T = TypeVar("T")

# Long enough that little is lost between slices, short enough for the window to answer.
SECONDS_OF_SLICE = 0.15
SECONDS_BETWEEN_SLICES = 0.01
CATEGORY = "Shape Google"


def next_slice(steps: Iterator[object], clock: Callable[[], float] = time.monotonic) -> bool:
    """Do some of the steps of a task, for as long as the window may wait.

    Parameters
    ----------
    steps : iterator
        Does a step each time it is asked for another value. Whatever is true ends the slice at once: the next
        step, or the last one, takes long by itself.
    clock : callable, optional

    Returns
    -------
    more : bool
        Whether there may be more steps.
    """
    end = clock() + SECONDS_OF_SLICE
    return any(alone or clock() > end for alone in steps)


def aside(work: Callable[[], T]) -> Generator[bool, None, T]:
    """Compute in another thread, as a step of a task; meanwhile the window answers.

    Parameters
    ----------
    work : callable
        Uses arrays alone, nothing of bpy. If the task is cancelled, it is computed to its end for nothing.

    Yields
    ------
    alone : bool
        True as long as it runs; see `next_slice`.

    Returns
    -------
    result : object
        Of the work, whose exceptions are raised here.
    """
    future: Future[T] = Future()

    def compute() -> None:
        try:
            future.set_result(work())
        except BaseException as error:
            future.set_exception(error)

    thread = threading.Thread(target=compute, daemon=True)
    thread.start()
    while True:
        # Returns as soon as it has ended; and without the window, nobody waits in between.
        thread.join(SECONDS_BETWEEN_SLICES)
        if not thread.is_alive():
            return future.result()
        yield True


def result_of(steps: Generator[bool, None, T]) -> T:
    """Do all steps of a task at a stretch.

    Parameters
    ----------
    steps : generator

    Returns
    -------
    result : object
        What the steps return.
    """
    while True:
        try:
            next(steps)
        except StopIteration as end:
            result: T = end.value
            return result


class InSlices:
    """Base of operators whose work is an iterator that yields wherever it may be interrupted.

    See `next_slice` for what it yields.

    While it runs, the window takes clicks in the add-on's sidebar and Esc, and nothing that could change the
    scene.

    Attributes
    ----------
    stopped : bool
        Set by whoever wants the work to end at the next step.
    """

    stopped = False

    def begin(self, context: Any, steps: Iterator[object]) -> set[str]:
        """Start the work; for `invoke`."""
        self._steps = steps
        manager = context.window_manager
        self._timer = manager.event_timer_add(SECONDS_BETWEEN_SLICES, window=context.window)
        manager.modal_handler_add(self)
        self.show_progress(context)
        return {"RUNNING_MODAL"}

    def show_progress(self, context: Any) -> None:
        """Show what has been done so far, and set the text of the status bar."""
        raise NotImplementedError

    def finish(self, context: Any, *, cancelled: bool) -> set[str]:
        """Report what was done; returns the operator's result."""
        raise NotImplementedError

    def modal(self, context: Any, event: Any) -> set[str]:
        """Do some steps at each tick of the timer."""
        if self.stopped or (event.type == "ESC" and event.value == "PRESS"):
            self.cancel(context)
            return self.finish(context, cancelled=True)
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if _is_in_sidebar(context, event) else {"RUNNING_MODAL"}
        try:
            more = next_slice(self._steps)
        except BaseException:
            self.cancel(context)
            raise
        if more:
            self.show_progress(context)
            jobs.redraw()
            return {"PASS_THROUGH"}
        self.cancel(context)
        return self.finish(context, cancelled=False)

    def cancel(self, context: Any) -> None:
        """Stop the timer. Blender calls it too when it opens a file or ends."""
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        jobs.redraw()


def _is_in_sidebar(context: Any, event: Any) -> bool:
    """Whether the mouse moves or clicks in the add-on's tab, where the button to cancel is."""
    if event.type not in {"LEFTMOUSE", "MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}:
        return False
    return any(
        0 <= event.mouse_x - region.x < region.width and 0 <= event.mouse_y - region.y < region.height
        for area in context.window.screen.areas
        if area.type == "VIEW_3D"
        for region in area.regions
        if region.type == "UI" and region.active_panel_category == CATEGORY
    )
