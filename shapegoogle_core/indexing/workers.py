# SPDX-License-Identifier: MIT
"""Worker processes that describe mesh files: one that hangs, crashes or eats the memory costs one file."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import resource_tracker
from pathlib import Path
from types import TracebackType
from typing import Self

from pebble import ProcessExpired, ProcessPool
from threadpoolctl import threadpool_limits

from shapegoogle_core.errors import MeshError, ShapeGoogleError
from shapegoogle_core.indexing.readers import ExternalReader, FoundShape, read_shapes
from shapegoogle_core.model import ShapeModel, ShapeSignature, load_model
from shapegoogle_core.rendering import thumbnail

__all__ = ["DescribedFile", "DescribedShape", "Failure", "Workers", "default_jobs", "describe_file"]

# A worker starts afresh after so many files, so that what libraries leak does not add up over a long run.
FILES_PER_WORKER = 500
# So often in a row all processes may die before any file is done; then something other than a file is wrong.
MAX_RESTARTS = 2


@dataclass(frozen=True, eq=False)
class DescribedShape:
    """What a worker makes of one shape.

    Attributes
    ----------
    object_name : str
        Of the object inside its file; empty for a file that is one shape.
    signature : ShapeSignature
    thumbnail : bytes or None
        A picture as PNG.
    """

    object_name: str
    signature: ShapeSignature
    thumbnail: bytes | None


@dataclass(frozen=True, eq=False)
class DescribedFile:
    """What a worker makes of one file.

    Attributes
    ----------
    shapes : tuple of DescribedShape
        None if the file holds no mesh, as a .blend file of materials.
    problem : str
        A sentence on the parts that could not be described, else empty.
    """

    shapes: tuple[DescribedShape, ...]
    problem: str = ""


@dataclass(frozen=True)
class Failure:
    """Why a file could not be described.

    Attributes
    ----------
    reason : str
        One sentence for the user.
    details : str
        The traceback of an error nobody foresaw, else empty.
    """

    reason: str
    details: str = ""


DescribeFunction = Callable[[Path, ShapeModel], DescribedFile]


def describe_file(path: Path, model: ShapeModel, reader: ExternalReader | None = None) -> DescribedFile:
    """Read one file and describe its shapes.

    Parameters
    ----------
    path : Path
    model : ShapeModel
    reader : ExternalReader, optional
        For files that this package does not read.

    Returns
    -------
    described : DescribedFile

    Raises
    ------
    MeshError
        If the file cannot be read, or none of its shapes can be described.
    """
    found = read_shapes(path, reader)
    described: dict[int, DescribedShape] = {}
    problems = list(found.problems)
    for index, shape in enumerate(found.shapes):
        try:
            described[index] = _describe_shape(shape, described, model)
        except MeshError as error:
            problems.append(str(error))
    if problems and not described:
        raise MeshError("; ".join(problems))
    problem = ""
    if problems:
        total = len(found.shapes) + len(found.problems)
        problem = f"{path.name!r}: {len(problems)} of {total} objects failed: {'; '.join(problems)}"
    return DescribedFile(tuple(described.values()), problem)


def _describe_shape(
    shape: FoundShape, described: Mapping[int, DescribedShape], model: ShapeModel
) -> DescribedShape:
    twin = None if shape.twin_of is None else described.get(shape.twin_of)
    if twin is not None:
        # Neither the signature nor the picture depends on place and size.
        signature = replace(twin.signature, area=shape.mesh.area)
        return DescribedShape(shape.object_name, signature, twin.thumbnail)
    return DescribedShape(
        shape.object_name, model.describe(shape.mesh), thumbnail(shape.mesh, up_axis=shape.up_axis)
    )


def default_jobs() -> int:
    """Return the number of processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Workers:
    """A few processes that describe files, each started once and given one file at a time.

    Use it as a context manager: leaving the block ends the processes, whatever they are doing.

    Parameters
    ----------
    describe : callable
        ``describe(path, model)``, a function that a new Python process can import by its name.
    model : ShapeModel
        Sent to each process once, when it starts.
    jobs : int
        How many processes.
    time_limit : float
        Seconds that one file may take; its process is killed then and replaced.
    memory_limit : int
        Megabytes that one file may need beyond what an idle process holds. Enforced on Linux only: macOS and
        Windows have no such limit for a process.
    """

    def __init__(
        self,
        describe: DescribeFunction,
        model: ShapeModel,
        *,
        jobs: int,
        time_limit: float,
        memory_limit: int,
    ) -> None:
        # In a file: a process that dies before it has read all it is sent keeps its starter waiting for ever.
        self._folder = tempfile.TemporaryDirectory(prefix="shapegoogle-")
        model_file = Path(self._folder.name, "model.npz")
        model_file.write_bytes(model.to_bytes())
        self._start_values = (describe, model_file, memory_limit)
        self._jobs = jobs
        self._time_limit = time_limit
        self._paths: dict[Future[DescribedFile | Failure], Path] = {}
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
        return len(self._paths)

    def submit(self, path: Path) -> None:
        """Hand in a file; the first one starts the processes."""
        try:
            future = self._schedule(path)
        except RuntimeError:  # pebble's word for a pool that broke while nobody waited for it
            self._restart()
            future = self._schedule(path)
        self._paths[future] = path

    def finished(self) -> list[tuple[Path, DescribedFile | Failure]]:
        """Wait until at least one file is done and return those that are.

        Raises
        ------
        ShapeGoogleError
            If the processes die again and again before any file is done.
        """
        results: list[tuple[Path, DescribedFile | Failure]] = []
        while self._paths and not results:
            done, _ = wait(self._paths, return_when=FIRST_COMPLETED)
            for future in done:
                error = future.exception()
                if not isinstance(error, BrokenProcessPool):
                    path = self._paths.pop(future)
                    results.append((path, self._outcome(path, future)))
            if results:
                self._restarts = 0
            else:
                self._restart()
        return results

    def _outcome(self, path: Path, future: Future[DescribedFile | Failure]) -> DescribedFile | Failure:
        error = future.exception()
        if error is None:
            return future.result()
        if isinstance(error, TimeoutError):
            return Failure(
                f"{path.name!r} was not done after {self._time_limit:g} s and given up; simplify it or raise "
                "the time limit"
            )
        if isinstance(error, ProcessExpired):
            return Failure(
                f"{path.name!r} crashed the process that read it ({_cause_of_death(error.exitcode)}); export "
                "it again or simplify it"
            )
        return Failure(
            f"{path.name!r} ended the process that read it ({type(error).__name__}: {error})",
            "".join(traceback.format_exception(error)),
        )

    def _schedule(self, path: Path) -> Future[DescribedFile | Failure]:
        with _interrupts_blocked():
            future: Future[DescribedFile | Failure] = self._pool.schedule(
                _describe_in_worker, args=(path,), timeout=self._time_limit
            )
        return future

    def _new_pool(self) -> ProcessPool:
        return ProcessPool(
            max_workers=self._jobs,
            max_tasks=FILES_PER_WORKER,
            initializer=_start_worker,
            initargs=self._start_values,
            # A forked copy of a process with threads may hang; spawn is also the only way on Windows.
            context=multiprocessing.get_context("spawn"),
        )

    def _restart(self) -> None:
        """Replace a pool whose bookkeeping broke and hand in again what it had not finished."""
        self._restarts += 1
        if self._restarts > MAX_RESTARTS:
            raise ShapeGoogleError(
                "the worker processes end before they do anything; a script that indexes must do so under "
                "`if __name__ == '__main__':`, and the machine needs free memory"
            )
        self._stop()
        self._pool = self._new_pool()
        unfinished, self._paths = list(self._paths.values()), {}
        for path in unfinished:
            self._paths[self._schedule(path)] = path

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


# What a worker process was started with; set once in each by `_start_worker`.
_worker: tuple[DescribeFunction, ShapeModel, int] | None = None


def _start_worker(describe: DescribeFunction, model_file: Path, memory_limit: int) -> None:
    global _worker
    threading.Thread(target=_end_with_parent, daemon=True).start()
    threadpool_limits(1)
    # What a library prints must not end up in the middle of `--json`.
    os.dup2(sys.__stderr__.fileno() if sys.__stderr__ else os.open(os.devnull, os.O_WRONLY), 1)
    _worker = describe, load_model(model_file), memory_limit
    _limit_memory(memory_limit)


def _end_with_parent() -> None:
    """End this process when its parent is gone, killed perhaps: nobody else would stop it if it hangs."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _limit_memory(megabytes: int) -> None:
    """Let this process have so much memory on top of what it holds now, and leave no core file in a crash."""
    if sys.platform == "linux":
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + megabytes * 2**20
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        if hard == resource.RLIM_INFINITY or limit < hard:
            resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _describe_in_worker(path: Path) -> DescribedFile | Failure:
    assert _worker is not None
    describe, model, memory_limit = _worker
    try:
        return describe(path, model)
    except Exception as error:
        if isinstance(error, MemoryError) or isinstance(error.__cause__, MemoryError):
            return Failure(
                f"{path.name!r} needs more than {memory_limit} MB of memory; simplify it or raise the memory "
                "limit"
            )
        if isinstance(error, MeshError):
            return Failure(str(error))
        # Turned into text here: an exception of a library may not survive the way to the main process.
        return Failure(
            f"{path.name!r} cannot be described (unexpected {type(error).__name__}: {error})",
            traceback.format_exc(),
        )


def _cause_of_death(exit_code: int) -> str:
    if exit_code >= 0 or sys.platform == "win32":
        return f"exit code {exit_code}"
    name = signal.Signals(-exit_code).name if -exit_code in set(signal.Signals) else f"signal {-exit_code}"
    if name == "SIGKILL":
        return f"{name}: the system ended it, as it does when memory runs out"
    return name
