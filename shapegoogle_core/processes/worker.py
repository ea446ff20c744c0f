# SPDX-License-Identifier: MIT
"""One process that computes for a program with a window.

Not of `multiprocessing`: that runs the main script again in every process it starts, and a user's script in
Blender begins with ``import bpy``, which only Blender has, and goes on to do things that must not be done
twice. Tasks and results are pickled, between a process and the one it has started itself, never from a file.
"""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from queue import SimpleQueue
from typing import Any, TypeVar

from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.processes.launching import NO_WINDOW, THREAD_VARIABLES, divert_output

__all__ = ["Task", "Worker", "serve"]

T = TypeVar("T")

# The worker finds its modules where this process does: Blender's extensions bring paths of their own.
_START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from shapegoogle_core.processes.worker import serve; serve()"
)


class Task(Future[T]):
    """What a task will result in; one that is cancelled while it runs takes its process along."""

    def __init__(self, worker: Worker) -> None:
        super().__init__()
        self._worker = worker
        self.abandoned = False

    def cancel(self) -> bool:
        """Stop the task, also if it runs already; False if it is done."""
        if super().cancel():
            return True
        return self._worker.abandon(self)


_Entry = tuple[Task[Any], Callable[..., Any], tuple[object, ...]]


class Worker:
    """A process of the core, started at the first task; tasks run one after the other.

    A process that dies costs the task it was at; the next one starts another process.
    """

    def __init__(self) -> None:
        self._tasks: SimpleQueue[_Entry | None] = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._process: subprocess.Popen[bytes] | None = None
        # Held while a task begins or ends, so that a late `cancel` does not hit the next one's process.
        self._lock = threading.Lock()
        self._current: Task[Any] | None = None

    @property
    def started(self) -> bool:
        """Whether there ever was a task."""
        return self._thread is not None

    def submit(self, function: Callable[..., T], *arguments: object) -> Task[T]:
        """Hand in a task.

        Parameters
        ----------
        function : callable
            That the process can import by its name: one of the core.
        *arguments : object
            Picklable.

        Returns
        -------
        task : Task
            Its result is what the function returns; its exception what it raises, or a `ShapeGoogleError`
            if the process dies.
        """
        task: Task[T] = Task(self)
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, daemon=True)
            self._thread.start()
        self._tasks.put((task, function, arguments))
        return task

    def kill(self) -> None:
        """End the process, whatever it is doing."""
        process = self._process
        if process is not None:
            process.kill()

    def abandon(self, task: Task[Any]) -> bool:
        """End the process if it is at this task; False if the task is done."""
        with self._lock:
            if self._current is not task:
                return False
            task.abandoned = True
            self.kill()
            return True

    def stop(self) -> None:
        """End the process, give up all tasks, and wait until that is done."""
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
            # Again and again: it may be about to start the process for a task that it has taken already.
            self.kill()
            self._thread.join(0.1)
        self._thread = None

    def _work(self) -> None:
        while (entry := self._tasks.get()) is not None:
            task, function, arguments = entry
            with self._lock:
                if not task.set_running_or_notify_cancel():
                    continue
                self._current = task
            try:
                succeeded, result = self._ask(task, function, arguments)
            except Exception as error:  # whatever it was must reach the one who waits
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
            process = self._running()
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(message)
            process.stdin.flush()
            answer: tuple[bool, Any] = pickle.load(process.stdout)
            return answer
        except (OSError, EOFError, pickle.UnpicklingError) as error:
            self._end()
            raise ShapeGoogleError(
                f"the process that computes has ended unexpectedly (exit code {process.returncode}), perhaps "
                "for want of memory; try again with a simpler shape"
            ) from error

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._process.poll() is not None:
            self._end()
        if self._process is None:
            try:
                self._process = subprocess.Popen(
                    [sys.executable, "-c", _START, json.dumps(sys.path)],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    creationflags=NO_WINDOW,
                    env={**dict.fromkeys(THREAD_VARIABLES, "1"), **os.environ},
                )
            except OSError as error:
                raise ShapeGoogleError(
                    f"Python cannot be started at {sys.executable!r} ({error.strerror or error}); install "
                    "Blender again, or use another build of it"
                ) from error
        return self._process

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    # Closing may want to write what a dead process will not read.
                    with suppress(BrokenPipeError):
                        stream.close()


def serve() -> None:
    """Do one task after the other, from standard input to standard output, until the input is closed."""
    # What a library prints must not end up among the answers.
    answers = os.fdopen(divert_output(), "wb")
    while True:
        try:
            function, arguments = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        answers.write(_answer(function, arguments))
        answers.flush()


def _answer(function: Callable[..., Any], arguments: tuple[object, ...]) -> bytes:
    try:
        return pickle.dumps((True, function(*arguments)), protocol=pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        # An exception of a library may not survive the way; its text does.
        known = isinstance(error, ShapeGoogleError)
        sent = error if known else ShapeGoogleError(f"unexpected {type(error).__name__}: {error}")
        return pickle.dumps((False, sent), protocol=pickle.HIGHEST_PROTOCOL)
