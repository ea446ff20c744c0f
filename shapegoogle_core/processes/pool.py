# SPDX-License-Identifier: MIT
"""A pool of processes in which a task that hangs, crashes or needs too much memory costs only itself."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Self, TypeVar

from pebble import ProcessExpired, ProcessPool
from threadpoolctl import threadpool_limits

from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.processes.launching import (
    cause_of_death,
    divert_output,
    end_with_parent,
    interrupts_blocked,
    limit_memory,
    single_threaded,
)
from shapegoogle_core.processes.temporary import VARIABLES

__all__ = ["CrashError", "Pool", "PoolTask", "Spent", "TimeLimitError"]

R = TypeVar("R")

# A process is replaced after this number of tasks, so that memory leaks of libraries do not add up.
TASKS_PER_PROCESS = 1000
# Number of tasks handed out per process: enough to keep all of them busy.
TASKS_AHEAD = 3
# Number of times in a row that all processes may die before a task is done; after that no task is to blame.
MAX_RESTARTS = 2
# Seconds between two looks for lost tasks, and after which a task is lost that belongs to no process.
LOOK_AGAIN, LOST_AFTER = 1.0, 5.0
# Signals that ask a process to end; Windows has some of them.
ASKING = {getattr(signal, name) for name in ("SIGHUP", "SIGINT", "SIGTERM") if hasattr(signal, name)}


class TimeLimitError(Exception):
    """A task took longer than its time limit, and its process was killed."""


class CrashError(Exception):
    """A task ended its process; the message says how, such as "SIGSEGV" or "exit code 3".

    Parameters
    ----------
    exit_code : int
        Negative for a signal.
    """

    def __init__(self, exit_code: int) -> None:
        super().__init__(cause_of_death(exit_code))
        self.exit_code = exit_code

    @property
    def asked(self) -> bool:
        """Whether somebody asked the process to end: the task is not to blame."""
        return -self.exit_code in ASKING


@dataclass(frozen=True)
class Spent:
    """Time that a process spent on a task.

    Attributes
    ----------
    seconds : float
    idle : float
        Seconds for which the process had waited for the task.
    """

    seconds: float = 0.0
    idle: float = 0.0


@dataclass(eq=False)
class PoolTask(Generic[R]):
    """A task of a `Pool`.

    Attributes
    ----------
    function : callable
    arguments : tuple
    limited : bool
        Whether the pool's time limit holds for it.
    done : bool
        Whether `Pool.finished` has returned it.
    """

    function: Callable[..., R]
    arguments: tuple[object, ...]
    limited: bool = True
    done: bool = False
    _future: Future[tuple[R, Spent]] = field(default_factory=Future, repr=False)

    @property
    def spent(self) -> Spent:
        """Time spent on it once it is done; nothing is known of a task that failed."""
        return Spent() if self._future.exception() is not None else self._future.result()[1]

    def result(self) -> R:
        """Return the result of the function.

        Returns
        -------
        result : object

        Raises
        ------
        TimeLimitError
            If the task took too long.
        CrashError
            If it ended its process.
        Exception
            Whatever the function raised.
        """
        try:
            result, _ = self._future.result()
        except TimeoutError as error:
            raise TimeLimitError("the time limit was exceeded") from error
        except ProcessExpired as error:
            raise CrashError(error.exitcode) from error
        return result


class Pool:
    """Worker processes that each run one task at a time.

    Use it as a context manager: leaving the block ends the processes, whatever they are doing. They are
    started when the first task is submitted, by ``spawn``, so a script must do so under
    ``if __name__ == "__main__":``. Their libraries compute on one thread, and everything they print goes to
    standard error.

    Parameters
    ----------
    jobs : int
        Number of processes.
    time_limit : float or None
        Seconds that a task may take; its process is killed then, and replaced. None for no limit.
    memory_limit : int, optional
        Megabytes that a task may need beyond what an idle process holds. Enforced on Linux only: macOS and
        Windows have no such limit for a process.
    folder : Path, optional
        Existing folder for all temporary files of the processes. Someone who is killed cleans up nothing, so
        the caller removes the folder after the block.
    start : callable, optional
        Runs once in each process; its result is the first argument of every task. Like the functions of
        tasks, it must be importable by its name.
    start_arguments : tuple, optional
        Pickled for each process. Large values belong in a file: a process that dies before it has read them
        would keep this one waiting for ever.

    Examples
    --------
    >>> from shapegoogle_core.processes.pool import Pool
    >>> def squares(numbers):
    ...     with Pool(jobs=2, time_limit=60) as pool:
    ...         return [task.result() for task in pool.map(abs, numbers)]
    """

    def __init__(
        self,
        jobs: int,
        time_limit: float | None,
        *,
        memory_limit: int | None = None,
        folder: Path | None = None,
        start: Callable[..., object] | None = None,
        start_arguments: tuple[object, ...] = (),
    ) -> None:
        self._jobs = jobs
        self._time_limit = time_limit
        self._start_values = (memory_limit, folder, start, start_arguments)
        self._first: deque[PoolTask[Any]] = deque()
        self._waiting: deque[PoolTask[Any]] = deque()
        self._running: dict[Future[Any], PoolTask[Any]] = {}
        self._restarts = 0
        self._ownerless: dict[int, float] = {}
        self._pool = self._new_pool()
        self._environment = ExitStack()

    def __enter__(self) -> Self:
        self._environment.enter_context(single_threaded())
        return self

    def __exit__(self, *_error: object) -> None:
        with self._environment:
            self._stop()

    def __len__(self) -> int:
        """Return the number of submitted tasks that `finished` has not returned yet."""
        return len(self._first) + len(self._waiting) + len(self._running)

    def submit(
        self, function: Callable[..., R], *arguments: object, first: bool = False, limited: bool = True
    ) -> PoolTask[R]:
        """Submit a task.

        Parameters
        ----------
        function : callable
            Called in a process with the result of `start`, if there is one, and the arguments.
        *arguments : object
            Pickled.
        first : bool, optional
            Whether it is run before all tasks that are not.
        limited : bool, optional
            Whether the time limit holds for it; otherwise it must have a limit of its own.

        Returns
        -------
        task : PoolTask

        Raises
        ------
        ShapeGoogleError
            If the processes cannot be started.
        """
        task = PoolTask(function, arguments, limited)
        (self._first if first else self._waiting).append(task)
        self._hand_out()
        return task

    def finished(self, timeout: float | None = None) -> list[PoolTask[Any]]:
        """Wait until at least one task is done.

        Parameters
        ----------
        timeout : float, optional
            Seconds to wait at most.

        Returns
        -------
        tasks : list of PoolTask
            All that are done and were not returned before; empty if there are no tasks, or after the timeout.

        Raises
        ------
        ShapeGoogleError
            If the processes die again and again before any task is done.
        """
        end = None if timeout is None else time.monotonic() + timeout
        while len(self):
            self._hand_out()
            left = LOOK_AGAIN if end is None else min(LOOK_AGAIN, max(0.0, end - time.monotonic()))
            done, _ = wait(self._running, left, return_when=FIRST_COMPLETED)
            if not done:
                if self._has_lost_a_task():
                    self._restart()
                elif end is not None and time.monotonic() >= end:
                    return []
                continue
            whole = [future for future in done if not isinstance(future.exception(), BrokenProcessPool)]
            if not whole:
                self._restart()
                continue
            self._restarts = 0
            tasks = [self._running.pop(future) for future in whole]
            for task in tasks:
                task.done = True
            return tasks
        return []

    def map(self, function: Callable[..., R], items: Iterable[object]) -> Iterator[PoolTask[R]]:
        """Run a function for each item; nothing else may be submitted meanwhile.

        Parameters
        ----------
        function : callable
            See `submit`.
        items : iterable

        Yields
        ------
        task : PoolTask
            In the order of the items, each as soon as it and all before it are done.

        Raises
        ------
        ShapeGoogleError
            If the processes die again and again before any task is done.
        """
        for task in [self.submit(function, item) for item in items]:
            while not task.done:
                self.finished()
            yield task

    def _hand_out(self) -> None:
        """Give the processes as many tasks as they can take."""
        while (queue := self._first or self._waiting) and len(self._running) < TASKS_AHEAD * self._jobs:
            task = queue[0]
            try:
                with interrupts_blocked():
                    task._future = self._pool.schedule(
                        _run,
                        args=(task.function, task.arguments),
                        timeout=self._time_limit if task.limited else None,
                    )
            except RuntimeError:  # raised by pebble if the pool broke while nobody was waiting for it
                self._restart()
                continue
            self._running[task._future] = queue.popleft()

    def _new_pool(self) -> ProcessPool:
        return ProcessPool(
            max_workers=self._jobs,
            max_tasks=TASKS_PER_PROCESS,
            initializer=_start,
            initargs=self._start_values,
            # A forked copy of a process with threads may hang; spawn is also the only way on Windows.
            context=multiprocessing.get_context("spawn"),
        )

    def _has_lost_a_task(self) -> bool:
        """Tell whether a task belongs to a process that has been gone for a while.

        Pebble reads that a process has begun a task, and that it has died, in two threads. If the second is
        known first, nobody is told that the task will never end.
        """
        manager, now = self._pool._pool_manager, time.monotonic()
        alive = manager.worker_manager.workers
        tasks = list(manager.task_manager.tasks.values())
        ownerless = [task.id for task in tasks if task.worker_id and task.worker_id not in alive]
        self._ownerless = {number: self._ownerless.get(number, now) for number in ownerless}
        return any(now - since > LOST_AFTER for since in self._ownerless.values())

    def _restart(self) -> None:
        """Replace a pool whose bookkeeping broke, and hand out its unfinished tasks again."""
        self._restarts += 1
        if self._restarts > MAX_RESTARTS:
            raise ShapeGoogleError(
                "the worker processes end before they do anything; a script that uses them must do so under "
                "`if __name__ == '__main__':`, and the machine needs free memory"
            )
        self._stop()
        self._pool = self._new_pool()
        self._ownerless = {}
        self._first.extendleft(reversed(self._running.values()))
        self._running.clear()

    def _stop(self) -> None:
        self._pool.stop()  # type: ignore[no-untyped-call]
        self._pool.join()


class _ThisProcess:
    """State of a worker process: the functions of tasks come without it, by their names."""

    started: tuple[object, ...] = ()
    """Result of `start`, if there is such a function."""
    idle_since: float | None = None
    """End of the last task."""


def _start(
    memory_limit: int | None,
    folder: Path | None,
    start: Callable[..., object] | None,
    arguments: tuple[object, ...],
) -> None:
    end_with_parent()
    threadpool_limits(1)
    # Output of libraries must not end up in the middle of `--json`.
    os.close(divert_output())
    if folder is not None:
        os.environ.update(dict.fromkeys(VARIABLES, str(folder)))
    if start is not None:
        _ThisProcess.started = (start(*arguments),)
    if memory_limit is not None:
        limit_memory(memory_limit)


def _run(function: Callable[..., R], arguments: tuple[object, ...]) -> tuple[R, Spent]:
    start = time.monotonic()
    idle = 0.0 if _ThisProcess.idle_since is None else start - _ThisProcess.idle_since
    try:
        result = function(*_ThisProcess.started, *arguments)
    finally:
        _ThisProcess.idle_since = time.monotonic()
    return result, Spent(_ThisProcess.idle_since - start, idle)
