# SPDX-License-Identifier: MIT
"""Describing the shapes of a benchmark in worker processes, each once; a failure costs only its shape."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from types import TracebackType
from typing import Any, Protocol, Self, TypeVar

from threadpoolctl import threadpool_limits

from benchmarks.errors import BenchmarkError
from benchmarks.protocol.cache import (
    PREPARATION_CODE,
    Arrays,
    BenchmarkCache,
    code_digest,
    content_digest,
    digest,
)
from benchmarks.protocol.collection import BenchmarkShape, NotMakeableError
from benchmarks.protocol.results import Problem
from shapegoogle_core.errors import MeshError, ShapeGoogleError
from shapegoogle_core.mesh import Mesh
from shapegoogle_core.processes.pool import CrashError, Pool, TimeLimitError
from shapegoogle_core.processes.progress import progress_bar

__all__ = ["Progress", "Source", "Task", "Workshop", "shape_key"]

T = TypeVar("T")
R = TypeVar("R")

Progress = Callable[[Iterable[Any], str, int], Iterable[Any]]
"""Wraps an iterable to show its progress: `progress(iterable, description, total)`."""

TIME_LIMIT = 900.0
"""Seconds that one shape may take."""


class Source(Protocol):
    """Source of a mesh: a `BenchmarkShape`, or a version of a training shape."""

    @property
    def name(self) -> str:
        """Name for error messages."""

    @property
    def key(self) -> str:
        """Digest of everything the mesh is made from."""

    def mesh(self) -> Mesh:
        """Make the mesh."""


@dataclass(frozen=True)
class _FileSource:
    """A `BenchmarkShape` with the digest of its file, so that workers need not read the file for it."""

    shape: BenchmarkShape
    key: str

    @property
    def name(self) -> str:
        return self.shape.name

    def mesh(self) -> Mesh:
        return self.shape.mesh()


def shape_key(shape: BenchmarkShape) -> str:
    """Compute the digest of everything a shape is made from, which excludes its name and path.

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
    """A computation for each shape, which is pickled for worker processes."""

    @property
    def title(self) -> str:
        """Description in the progress bar."""

    @property
    def kind(self) -> str:
        """Kind of its results in the cache."""

    @property
    def key(self) -> str:
        """Digest of everything its results depend on besides the shape."""

    def __call__(self, source: Source, cache: BenchmarkCache) -> Arrays:
        """Compute the result; raise `MeshError` for a shape that does not allow it."""


@dataclass(eq=False)
class Workshop:
    """The cache, the worker processes and the problems of a run.

    Use it as a context manager, which starts and ends the worker processes; without worker processes this is
    not necessary.

    Attributes
    ----------
    cache : BenchmarkCache
    jobs : int
        Number of worker processes; 0 computes in this process.
    progress : callable
        Wraps an iterable: `progress(iterable, description, total)`.
    left_out : dict of str to str
        Queries that cannot be generated from their null shapes, with the reason.
    failures : dict of str to str
        Shapes that could not be read or described, with the task and the reason.
    notes : dict of str to str
        Remarks on variants.
    """

    cache: BenchmarkCache
    jobs: int = 1
    progress: Progress = progress_bar
    left_out: dict[str, str] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    _pool: Pool | None = field(default=None, init=False, repr=False)

    def __enter__(self) -> Self:
        if self.jobs:
            self._pool = Pool(self.jobs, TIME_LIMIT).__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._pool is not None:
            self._pool.__exit__(kind, error, trace)
            self._pool = None

    @property
    def problems(self) -> tuple[Problem, ...]:
        """All problems, for the report."""
        kinds = {"left out": self.left_out, "failed": self.failures, "note": self.notes}
        return tuple(
            Problem(name, kind, reason) for kind, reasons in kinds.items() for name, reason in reasons.items()
        )

    def describe(self, task: Task, shapes: Sequence[BenchmarkShape]) -> list[Arrays | None]:
        """Run a task for each shape of a collection.

        Parameters
        ----------
        task : Task
        shapes : sequence of BenchmarkShape

        Returns
        -------
        descriptions : list of dict of str to array, or None
            None for a shape that failed or cannot be made; `problems` has the reasons.
        """
        return self.describe_sources(task, [_FileSource(shape, shape_key(shape)) for shape in shapes])

    def describe_sources(self, task: Task, sources: Sequence[Source]) -> list[Arrays | None]:
        """Run a task for each source of a mesh; otherwise as `describe`.

        Parameters
        ----------
        task : Task
        sources : sequence of Source

        Returns
        -------
        descriptions : list of dict of str to array, or None
        """
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
        """Compute results that do not belong to one shape, such as vocabularies, unless that was done before.

        Parameters
        ----------
        kind : str
            Kind of the results in the cache.
        function : callable
            Takes one item; both are pickled for worker processes.
        items : sequence
        keys : sequence of str
            Digest of everything that the result for each item depends on.
        title : str
            Description in the progress bar.

        Returns
        -------
        results : list of dict of str to array

        Raises
        ------
        BenchmarkError
            If one of them fails, because a variant needs all of them.
        """
        found = [self.cache.load(kind, key) for key in keys]
        missing = [index for index, arrays in enumerate(found) if arrays is None]
        outcomes = self.run(function, [items[index] for index in missing], title)
        for index, outcome in zip(missing, outcomes, strict=True):
            if isinstance(outcome, Exception):
                raise BenchmarkError(f"{title} failed: {_cause(outcome)}; run it again") from outcome
            found[index] = self.cache.remembered(kind, keys[index], partial(_result, outcome))
        return [arrays for arrays in found if arrays is not None]

    def run(self, function: Callable[[T], R], items: Sequence[T], title: str) -> list[R | Exception]:
        """Apply a function to all items, in worker processes.

        Parameters
        ----------
        function : callable
            Takes one item; both are pickled for worker processes.
        items : sequence
        title : str
            Description in the progress bar.

        Returns
        -------
        outcomes : list of results and exceptions
            In the order of the items; an exception where the function raised it, its process ended, or it
            took longer than `TIME_LIMIT`.

        Raises
        ------
        BenchmarkError
            If the function raises it, for example because the cache cannot be written.
        ValueError
            If there are no worker processes because the workshop is not used as a context manager.
        """
        if not items:
            return []
        if self.jobs == 0:
            with threadpool_limits(1):
                return [_attempt(partial(function, item)) for item in self.progress(items, title, len(items))]
        if self._pool is None:
            raise ValueError("no worker processes; use the workshop in a with statement")
        tasks = self.progress(self._pool.map(function, items), title, len(items))
        return [_attempt(task.result) for task in tasks]


@dataclass(frozen=True)
class _Outcome:
    problem: str = ""
    left_out: bool = False


def _attempt(function: Callable[[], R]) -> R | Exception:
    try:
        return function()
    except BenchmarkError:
        raise
    except Exception as error:  # whatever a library raises for a mesh costs only that mesh
        return error


def _cause(error: Exception) -> str:
    if isinstance(error, TimeLimitError):
        return f"it took longer than {TIME_LIMIT:g} s"
    if isinstance(error, CrashError):
        return f"its process ended ({error})"
    if isinstance(error, ShapeGoogleError):
        return str(error)
    traceback.print_exception(error)
    return "a fault in Shape Google, which the traceback on stderr shows"


def _result(arrays: Arrays) -> Arrays:
    return arrays


def _work(task: Task, cache: BenchmarkCache, item: tuple[Source, str]) -> _Outcome:
    source, key = item
    try:
        cache.remembered(task.kind, key, partial(task, source, cache))
    except NotMakeableError as error:
        return _Outcome(str(error), left_out=True)
    except MeshError as error:
        return _Outcome(str(error))
    return _Outcome()
