# SPDX-License-Identifier: MIT
"""Describing all shapes of a benchmark in worker processes, each once, whatever becomes of one of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import get_context
from typing import Any, Protocol, TypeVar

from pebble import ProcessExpired, ProcessPool
from threadpoolctl import threadpool_limits

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.collection import BenchmarkShape, NotMakeableError
from benchmarks.protocol.results import Problem
from benchmarks.protocol.spectra_cache import (
    PREPARATION_CODE,
    Arrays,
    BenchmarkCache,
    code_digest,
    content_digest,
    digest,
)
from shapegoogle_core.errors import MeshError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.processes.launching import single_threaded
from shapegoogle_core.processes.progress import progress_bar

__all__ = ["Progress", "Source", "Task", "Workshop", "shape_key"]

T = TypeVar("T")
R = TypeVar("R")

Progress = Callable[[Iterable[Any], str, int], Iterable[Any]]
"""Shows how far a loop is: `progress(iterable, description, total)`."""

TIME_LIMIT = 900.0
"""Seconds that one shape may take."""


class Source(Protocol):
    """Something a mesh comes from: a `BenchmarkShape`, or a version of a training shape."""

    @property
    def name(self) -> str:
        """What errors call it."""

    @property
    def key(self) -> str:
        """Digest of all that the mesh is made from."""

    def mesh(self) -> Mesh:
        """Make the mesh."""


@dataclass(frozen=True)
class _FileSource:
    """A `BenchmarkShape` whose file was hashed already: workers need not read it for its key."""

    shape: BenchmarkShape
    key: str

    @property
    def name(self) -> str:
        return self.shape.name

    def mesh(self) -> Mesh:
        return self.shape.mesh()


def shape_key(shape: BenchmarkShape) -> str:
    """Digest of all that a shape is made from: not its name, nor its place.

    Parameters
    ----------
    shape : BenchmarkShape

    Returns
    -------
    key : str
    """
    made = None if shape.seed is None else [shape.transformation, shape.strength, shape.seed]
    return digest(content_digest(shape.path), shape.path.suffix.lower(), made)


class Task(Protocol):
    """What is computed of each shape; travels to worker processes."""

    @property
    def title(self) -> str:
        """What the progress bar calls it."""

    @property
    def kind(self) -> str:
        """Folder of its entries in the cache."""

    @property
    def key(self) -> str:
        """Digest of all its results depend on besides the shape."""

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        """Compute it; raises `MeshError` for a shape that does not allow it."""


@dataclass(eq=False)
class Workshop:
    """Where shapes are described: the cache, the worker processes, and what went wrong.

    Attributes
    ----------
    cache : BenchmarkCache
    jobs : int
        Worker processes; 0 works in this one.
    progress : callable
        Wraps an iterable: `progress(iterable, description, total)`.
    left_out : dict of str to str
        Queries that cannot be made of their null shapes, and why.
    failures : dict of str to str
        Shapes that could not be read or described, with what was tried, and why.
    notes : dict of str to str
        What else there is to say of a variant.
    """

    cache: BenchmarkCache
    jobs: int = 1
    progress: Progress = progress_bar
    left_out: dict[str, str] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """All that went wrong, for the report."""
        kinds = {"left out": self.left_out, "failed": self.failures, "note": self.notes}
        return tuple(
            Problem(name, kind, reason) for kind, told in kinds.items() for name, reason in told.items()
        )

    def describe(self, task: Task, shapes: Sequence[BenchmarkShape]) -> list[Arrays | None]:
        """Compute something of each shape of a collection.

        Parameters
        ----------
        task : Task
        shapes : sequence of BenchmarkShape

        Returns
        -------
        descriptions : list of dict of str to array, or None
            None for a shape that failed or cannot be made; `problems` tells why.
        """
        return self.describe_sources(task, [_FileSource(shape, shape_key(shape)) for shape in shapes])

    def describe_sources(self, task: Task, sources: Sequence[Source]) -> list[Arrays | None]:
        """Compute something of anything that has meshes; else as `describe`."""
        depends = [task.key, code_digest(PREPARATION_CODE)]
        keys = [digest(source.key, depends) for source in sources]
        found = [self.cache.load(task.kind, key) for key in keys]
        missing = [index for index, arrays in enumerate(found) if arrays is None]
        work = partial(_work, task, self.cache)
        chosen = [(sources[index], keys[index]) for index in missing]
        for index, outcome in zip(missing, self.run(work, chosen, task.title), strict=True):
            name = sources[index].name
            if isinstance(outcome, Exception):
                outcome = _Outcome(f"{name!r} failed: {_cause(outcome)}")
            if outcome.left_out:
                self.left_out[name] = outcome.problem
            elif outcome.problem:
                self.failures.setdefault(name, f"{task.title}: {outcome.problem}")
            else:
                found[index] = self.cache.load(task.kind, keys[index])
        return found

    def remembered(
        self, kind: str, function: Callable[[T], Arrays], items: Sequence[T], keys: Sequence[str], title: str
    ) -> list[Arrays]:
        """Compute what is not of one shape, such as a vocabulary, unless that was done before.

        Parameters
        ----------
        kind : str
            Folder of the entries in the cache.
        function : callable
            Of one item; both travel to another process.
        items : sequence
        keys : sequence of str
            Digest of all that the result for each item depends on.
        title : str
            What the progress bar calls it.

        Returns
        -------
        results : list of dict of str to array

        Raises
        ------
        BenchmarkError
            If one of them fails: without it there is no variant.
        """
        found = [self.cache.load(kind, key) for key in keys]
        missing = [index for index, arrays in enumerate(found) if arrays is None]
        outcomes = self.run(function, [items[index] for index in missing], title)
        for index, outcome in zip(missing, outcomes, strict=True):
            if isinstance(outcome, Exception):
                raise BenchmarkError(f"{title} failed: {_cause(outcome)}; run it again") from outcome
            self.cache.store(kind, keys[index], outcome)
            found[index] = outcome
        return [arrays for arrays in found if arrays is not None]

    def run(self, function: Callable[[T], R], items: Sequence[T], title: str) -> list[R | Exception]:
        """Apply a function to all items, in worker processes.

        Parameters
        ----------
        function : callable
            Of one item; both travel to another process.
        items : sequence
        title : str
            What the progress bar calls it.

        Returns
        -------
        outcomes : list of results and exceptions
            In the order of the items: an exception where the function raised it, or where its process died
            or took longer than `TIME_LIMIT`.

        Raises
        ------
        BenchmarkError
            If the function raises it: the cache cannot be written, say.
        """
        if not items:
            return []
        if self.jobs == 0:
            with threadpool_limits(1):
                return [_attempt(function, item) for item in self.progress(items, title, len(items))]
        with (
            single_threaded(),
            ProcessPool(
                max_workers=min(self.jobs, len(items)), context=get_context("spawn"), initializer=_one_thread
            ) as pool,
        ):
            try:
                futures = [pool.schedule(function, [item], timeout=TIME_LIMIT) for item in items]
                waiting = self.progress(futures, title, len(futures))
                return [_attempt(lambda future: future.result(), future) for future in waiting]
            except BaseException:
                pool.stop()  # type: ignore[no-untyped-call]
                raise


@dataclass(frozen=True)
class _Outcome:
    problem: str = ""
    left_out: bool = False


def _attempt(function: Callable[[T], R], item: T) -> R | Exception:
    try:
        return function(item)
    except BenchmarkError:
        raise
    except Exception as error:  # whatever a mesh makes a library do costs only that mesh
        return error


def _cause(error: Exception) -> str:
    if isinstance(error, TimeoutError):
        return f"it took longer than {TIME_LIMIT:g} s"
    if isinstance(error, ProcessExpired):
        return f"its process ended (exit code {error.exitcode})"
    return f"{type(error).__name__}: {error}"


def _one_thread() -> None:
    threadpool_limits(1)


def _work(task: Task, cache: BenchmarkCache, item: tuple[Source, str]) -> _Outcome:
    source, key = item
    try:
        cache.store(task.kind, key, task(source, cache))
    except NotMakeableError as error:
        return _Outcome(str(error), left_out=True)
    except MeshError as error:
        return _Outcome(str(error))
    return _Outcome()
