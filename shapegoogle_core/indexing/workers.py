# SPDX-License-Identifier: MIT
"""Worker processes: a file or shape that hangs, crashes or eats the memory costs only itself.

A task is to read one file, or to describe one shape of it: many objects in a file take as long as they take,
all processes share them, and the time limit is for each.
"""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import sys
import tempfile
import traceback
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import count
from multiprocessing import resource_tracker
from pathlib import Path
from types import TracebackType
from typing import Self

from pebble import ProcessExpired, ProcessPool

from shapegoogle_core.errors import ShapeGoogleError
from shapegoogle_core.indexing.tasks import (
    DescribedShape,
    Failure,
    ReadFile,
    ReadFunction,
    describe_in_worker,
    read_in_worker,
    start_worker,
)
from shapegoogle_core.model import ShapeModel

__all__ = ["DescribedFile", "Workers", "default_jobs"]

# A worker starts afresh after so many tasks, so that what libraries leak does not add up over a long run.
TASKS_PER_WORKER = 1000
# Tasks that are handed to the pool, for each process: enough that none waits.
TASKS_AHEAD = 3
# So often in a row all processes may die before any task is done; then something other than a file is wrong.
MAX_RESTARTS = 2
# So many of a file's problems are told.
TOLD = 20


@dataclass(frozen=True, eq=False)
class DescribedFile:
    """What workers make of one file.

    Attributes
    ----------
    shapes : tuple of DescribedShape
        None if the file holds no mesh, as a .blend file of materials.
    problem : str
        A sentence on the parts that could not be described, else empty.
    """

    shapes: tuple[DescribedShape, ...]
    problem: str = ""


@dataclass(eq=False)
class _File:
    """A file in work: its folder for what is temporary, and what is known so far."""

    path: Path
    folder: Path
    found: ReadFile | None = None
    described: dict[int, DescribedShape | Failure] = field(default_factory=dict)

    def originals(self) -> list[int]:
        """Which of the shapes have to be described; the others are twins of these."""
        assert self.found is not None
        return [index for index, shape in enumerate(self.found.shapes) if shape.twin_of is None]

    def name_of(self, index: int) -> str:
        """Return what errors call a shape."""
        assert self.found is not None
        return self.found.shapes[index].object_name or self.path.name

    def outcome(self) -> DescribedFile | Failure:
        """Sum up the file when all originals are described."""
        assert self.found is not None
        failures = [Failure(problem) for problem in self.found.problems]
        shapes: dict[int, DescribedShape] = {}
        for index, shape in enumerate(self.found.shapes):
            if shape.twin_of is None:
                described = self.described[index]
                if isinstance(described, Failure):
                    failures.append(described)
                else:
                    shapes[index] = described
            elif shape.twin_of in shapes:
                # Neither the signature nor the picture depends on place and size.
                twin = shapes[shape.twin_of]
                signature = replace(twin.signature, area=shape.area)
                shapes[index] = DescribedShape(shape.object_name, signature, twin.thumbnail)
            else:
                name, twin_name = self.name_of(index), self.name_of(shape.twin_of)
                failures.append(Failure(f"{name!r} has the mesh of {twin_name!r}, which failed"))
        if not failures:
            return DescribedFile(tuple(shapes.values()))
        reasons = _told(failures)
        if not shapes:
            details = next((failure.details for failure in failures if failure.details), "")
            return Failure(reasons, details, lasting=all(failure.lasting for failure in failures))
        total = len(self.found.shapes) + len(self.found.problems)
        problem = f"{self.path.name!r}: {len(failures)} of {total} objects failed: {reasons}"
        return DescribedFile(tuple(shapes.values()), problem)


def _told(failures: Sequence[Failure]) -> str:
    reasons = [failure.reason for failure in failures[:TOLD]]
    if len(failures) > TOLD:
        reasons.append(f"and {len(failures) - TOLD} more")
    return "; ".join(reasons)


@dataclass(frozen=True, eq=False)
class _Task:
    """Reading a file, or describing one of its shapes."""

    file: _File
    shape: int | None = None

    @property
    def name(self) -> str:
        """What errors call it."""
        return self.file.path.name if self.shape is None else self.file.name_of(self.shape)


_Result = ReadFile | DescribedShape | Failure


def default_jobs() -> int:
    """Return the number of processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Workers:
    """A few processes that read and describe files, each started once and given one task at a time.

    Use it as a context manager: leaving the block ends the processes, whatever they are doing.

    Parameters
    ----------
    read : callable
        ``read(path)``, as `iterate_shapes`; a function that a new Python process can import by its name.
    model : ShapeModel
        Sent to each process once, when it starts.
    jobs : int
        How many processes.
    time_limit : float
        Seconds that reading one file or describing one shape may take; its process is killed then and
        replaced.
    memory_limit : int
        Megabytes that one task may need beyond what an idle process holds. Enforced on Linux only: macOS and
        Windows have no such limit for a process.
    """

    def __init__(
        self,
        read: ReadFunction,
        model: ShapeModel,
        *,
        jobs: int,
        time_limit: float,
        memory_limit: int,
    ) -> None:
        # A process that is killed may still be writing there when the folder goes away.
        self._folder = tempfile.TemporaryDirectory(prefix="shapegoogle-", ignore_cleanup_errors=True)
        # In a file: a process that dies before it has read all it is sent keeps its starter waiting for ever.
        model_file = Path(self._folder.name, "model.npz")
        model_file.write_bytes(model.to_bytes())
        self._start_values = (read, model_file, memory_limit)
        self._jobs = jobs
        self._time_limit = time_limit
        self._numbers = count()
        self._files = 0
        self._waiting: deque[_Task] = deque()
        self._running: dict[Future[_Result], _Task] = {}
        self._restarts = 0
        self._pool = self._new_pool()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop()
        self._folder.cleanup()

    def __len__(self) -> int:
        """Return the number of files handed in and not yet handed back."""
        return self._files

    def submit(self, path: Path) -> None:
        """Hand in a file; the first one starts the processes."""
        self._files += 1
        self._waiting.append(_Task(_File(path, Path(self._folder.name, str(next(self._numbers))))))
        self._hand_out()

    def finished(self) -> list[tuple[Path, DescribedFile | Failure]]:
        """Wait until at least one file is done and return those that are.

        Raises
        ------
        ShapeGoogleError
            If the processes die again and again before any task is done.
        """
        results: list[tuple[Path, DescribedFile | Failure]] = []
        while self._files and not results:
            self._hand_out()
            done, _ = wait(self._running, return_when=FIRST_COMPLETED)
            whole = [future for future in done if not isinstance(future.exception(), BrokenProcessPool)]
            if not whole:
                self._restart()
                continue
            self._restarts = 0
            for future in whole:
                task = self._running.pop(future)
                outcome = self._take(task, self._outcome(task, future))
                if outcome is not None:
                    results.append((task.file.path, outcome))
                    self._files -= 1
                    shutil.rmtree(task.file.folder, ignore_errors=True)
        return results

    def _take(self, task: _Task, result: _Result) -> DescribedFile | Failure | None:
        """Note what a task gave; returns what became of its file if it was the last one."""
        file = task.file
        if task.shape is None:
            if isinstance(result, Failure):
                return result
            assert isinstance(result, ReadFile)
            file.found = result
            # Before files that wait to be read, so that not ever more shapes wait on disk.
            self._waiting.extendleft(_Task(file, index) for index in reversed(file.originals()))
        else:
            assert not isinstance(result, ReadFile)
            file.described[task.shape] = result
        assert file.found is not None
        return file.outcome() if len(file.described) == len(file.originals()) else None

    def _outcome(self, task: _Task, future: Future[_Result]) -> _Result:
        error = future.exception()
        if error is None:
            return future.result()
        if isinstance(error, TimeoutError):
            return Failure(
                f"{task.name!r} was not done after {self._time_limit:g} s and given up; simplify it or raise "
                "the time limit"
            )
        if isinstance(error, ProcessExpired):
            did = "read" if task.shape is None else "described"
            return Failure(
                f"{task.name!r} crashed the process that {did} it ({_cause_of_death(error.exitcode)}); "
                "export it again or simplify it"
            )
        return Failure(
            f"{task.name!r} ended the process that worked on it ({type(error).__name__}: {error})",
            "".join(traceback.format_exception(error)),
        )

    def _hand_out(self) -> None:
        """Give the pool what it can take."""
        while self._waiting and len(self._running) < TASKS_AHEAD * self._jobs:
            try:
                future = self._schedule(self._waiting[0])
            except RuntimeError:  # pebble's word for a pool that broke while nobody waited for it
                self._restart()
                continue
            self._running[future] = self._waiting.popleft()

    def _schedule(self, task: _Task) -> Future[_Result]:
        file = task.file
        with _interrupts_blocked():
            future: Future[_Result]
            if task.shape is None:
                future = self._pool.schedule(
                    read_in_worker, args=(file.path, file.folder), timeout=self._time_limit
                )
            else:
                assert file.found is not None
                shape = file.found.shapes[task.shape]
                arguments = (file.found.arrays, shape, task.name)
                future = self._pool.schedule(describe_in_worker, args=arguments, timeout=self._time_limit)
        return future

    def _new_pool(self) -> ProcessPool:
        return ProcessPool(
            max_workers=self._jobs,
            max_tasks=TASKS_PER_WORKER,
            initializer=start_worker,
            initargs=self._start_values,
            # A forked copy of a process with threads may hang; spawn is also the only way on Windows.
            context=multiprocessing.get_context("spawn"),
        )

    def _restart(self) -> None:
        """Replace a pool whose bookkeeping broke; what it had not finished is handed out again."""
        self._restarts += 1
        if self._restarts > MAX_RESTARTS:
            raise ShapeGoogleError(
                "the worker processes end before they do anything; a script that indexes must do so under "
                "`if __name__ == '__main__':`, and the machine needs free memory"
            )
        self._stop()
        self._pool = self._new_pool()
        self._waiting.extendleft(reversed(self._running.values()))
        self._running.clear()

    def _stop(self) -> None:
        self._pool.stop()  # type: ignore[no-untyped-call]
        self._pool.join()


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Keep Ctrl-C, which goes to all processes of a terminal, from those that the block starts.

    They inherit the blocked signal, and so do the threads that start their successors. Without it a worker
    that is still importing prints a traceback. The signal itself arrives after the block.
    """
    if sys.platform == "win32":
        yield
        return
    # Starting this helper of multiprocessing unblocks the signal again, so it must run already.
    resource_tracker.ensure_running()
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)


def _cause_of_death(exit_code: int) -> str:
    if exit_code >= 0 or sys.platform == "win32":
        return f"exit code {exit_code}"
    name = signal.Signals(-exit_code).name if -exit_code in set(signal.Signals) else f"signal {-exit_code}"
    if name == "SIGKILL":
        return f"{name}: the system ended it, as it does when memory runs out"
    return name
