# SPDX-License-Identifier: MIT
"""One persistent process that computes for a program with a window.

It is no process of `multiprocessing`, which runs the main script again in every process it starts: a user's
script in Blender begins with ``import bpy``, which only Blender has, and continues with actions that must not
happen twice. Tasks and results are pickled, between a process and the one that it has started, never from a
file.
"""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from queue import SimpleQueue
from typing import Any, BinaryIO, TypeVar

from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.processes.launching import (
    block_broken_pipe_signal,
    cause_of_death,
    divert_output,
    launch,
    single_threaded,
)
from shapegoogle_core.processes.messages import (
    IncompleteMessageError,
    claim_message_pipe,
    read_frame,
    write_frame,
)
from shapegoogle_core.processes.temporary import remove_abandoned_folders

__all__ = ["Task", "Worker", "serve"]

T = TypeVar("T")

# Seconds that the process may take to end once it has closed its pipe.
PATIENCE = 5.0
# The worker searches modules where this process does: Blender's extensions add paths of their own.
_START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from shapegoogle_core.processes.worker import serve; serve()"
)


class Task(Future[T]):
    """Future result of a task; cancelling it while it runs ends its process.

    Attributes
    ----------
    abandoned : bool
        Whether it was cancelled while it ran.
    """

    def __init__(self, worker: Worker) -> None:
        super().__init__()
        self._worker = worker
        self.abandoned = False

    def cancel(self) -> bool:
        """Stop the task, even if it runs already.

        Returns
        -------
        cancelled : bool
            False if the task is done.
        """
        if super().cancel():
            return True
        return self._worker.abandon(self)


_Entry = tuple[Task[Any], Callable[..., Any], tuple[object, ...]]


class Worker:
    """A process that runs one task after the other, started at the first task.

    If the process dies, its task fails, and the next task starts another process.

    Examples
    --------
    >>> from shapegoogle_core.processes.worker import Worker
    >>> worker = Worker()
    >>> worker.submit(abs, -3).result()
    3
    >>> worker.stop()
    """

    def __init__(self) -> None:
        self._tasks: SimpleQueue[_Entry | None] = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._answers: BinaryIO | None = None
        # Held while a task begins or ends, so that a late `cancel` does not hit the next one's process.
        self._lock = threading.Lock()
        self._current: Task[Any] | None = None

    @property
    def started(self) -> bool:
        """Whether there ever was a task."""
        return self._thread is not None

    def submit(self, function: Callable[..., T], *arguments: object) -> Task[T]:
        """Submit a task.

        Parameters
        ----------
        function : callable
            One that the process can import by its name, as all of this package.
        *arguments : object
            Picklable.

        Returns
        -------
        task : Task
            With the result of the function, or the exception that it raised, or a `ShapeGoogleError` if the
            process dies.
        """
        task: Task[T] = Task(self)
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, daemon=True)
            self._thread.start()
        self._tasks.put((task, function, arguments))
        return task

    def kill(self) -> None:
        """Kill the process, whatever it is doing."""
        process = self._process
        if process is not None:
            process.kill()

    def abandon(self, task: Task[Any]) -> bool:
        """Kill the process if it runs this task.

        Parameters
        ----------
        task : Task

        Returns
        -------
        abandoned : bool
            False if the task is done.
        """
        with self._lock:
            if self._current is not task:
                return False
            task.abandoned = True
            self.kill()
            return True

    def stop(self) -> None:
        """End the process, cancel all tasks, and wait until that is done."""
        if self._thread is None:
            return
        waiting = []
        while not self._tasks.empty():
            waiting.append(self._tasks.get())
        for entry in waiting:
            if entry is not None:
                entry[0].cancel()
        self._tasks.put(None)
        while self._thread.is_alive():
            # Repeatedly: the thread may be about to start the process for a task that it has taken already.
            self.kill()
            self._thread.join(0.1)
        self._thread = None

    def _work(self) -> None:
        block_broken_pipe_signal()
        while (entry := self._tasks.get()) is not None:
            task, function, arguments = entry
            with self._lock:
                if not task.set_running_or_notify_cancel():
                    continue
                self._current = task
            try:
                succeeded, result = self._ask(task, function, arguments)
            except Exception as error:  # every error must reach the one who waits for the task
                succeeded, result = False, error
            with self._lock:
                self._current = None
            if task.abandoned:
                task.set_exception(CancelledError())
            elif succeeded:
                task.set_result(result)
            else:
                task.set_exception(result)
        self._end()

    def _ask(
        self, task: Task[Any], function: Callable[..., Any], arguments: tuple[object, ...]
    ) -> tuple[bool, Any]:
        message = pickle.dumps((function, arguments), protocol=pickle.HIGHEST_PROTOCOL)
        with self._lock:
            if task.abandoned:
                raise CancelledError
            process, answers = self._running()
        assert process.stdin is not None
        try:
            write_frame(process.stdin, message)
            content = read_frame(answers)
        except (OSError, IncompleteMessageError):
            content = None
        if content is None:
            with suppress(subprocess.TimeoutExpired):  # it is killed then
                process.wait(PATIENCE)
            self._end()
            raise ShapeGoogleError(
                "the process that computes has ended unexpectedly ({cause}); try again with a simpler shape",
                cause=cause_of_death(process.returncode),
            )
        answer: tuple[bool, Any] = pickle.loads(content)
        return answer

    def _running(self) -> tuple[subprocess.Popen[bytes], BinaryIO]:
        if self._process is not None and self._process.poll() is not None:
            self._end()
        if self._process is None or self._answers is None:
            command = [sys.executable, "-c", _START, json.dumps(sys.path)]
            try:
                with single_threaded():
                    self._process, self._answers = launch(command, with_output=False)
            except OSError as error:
                raise ShapeGoogleError(
                    "Python cannot be started at {program!r} ({reason}); install Blender again, or use "
                    "another build of it",
                    program=sys.executable,
                    reason=error.strerror,
                ) from error
        return self._process, self._answers

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            if process.stdin is not None:
                # Closing may try to write to a process that is dead.
                with suppress(BrokenPipeError):
                    process.stdin.close()
        if self._answers is not None:
            self._answers.close()
            self._answers = None


def serve() -> None:
    """Run tasks from standard input one after the other until it is closed; answer on the message pipe."""
    answers = claim_message_pipe()
    assert answers is not None
    # Standard output may be that of a command: what libraries print does not belong there.
    os.close(divert_output())
    remove_abandoned_folders()
    try:
        while (task := read_frame(sys.stdin.buffer)) is not None:
            answer = _answer(*pickle.loads(task))
            write_frame(answers, answer)
    except (IncompleteMessageError, BrokenPipeError):
        return  # the program that started this one has gone


def _answer(function: Callable[..., Any], arguments: tuple[object, ...]) -> bytes:
    try:
        return pickle.dumps((True, function(*arguments)), protocol=pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        # An exception of a library may not be picklable; its text is.
        if isinstance(error, ShapeGoogleError):
            sent = error
        else:
            traceback.print_exc()  # to the console of the program with the window
            sent = ShapeGoogleError(
                "this failed because of a fault in Shape Google; report it with the last lines of the console"
            )
        return pickle.dumps((False, sent), protocol=pickle.HIGHEST_PROTOCOL)
