# SPDX-License-Identifier: MIT
"""Steps of a training: run in worker processes or in this one, with their progress."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol, TypeVar

from shapegoogle_core.errors import ModelError
from shapegoogle_core.processes.pool import CrashError, Pool, PoolTask

__all__ = ["Progress", "Run", "run_here", "silent", "tasks_run"]

A = TypeVar("A")
T = TypeVar("T")


class Progress(Protocol):
    """Progress display of a loop, such as tqdm's."""

    def __call__(self, iterable: Iterable[T], description: str, total: int, /) -> Iterable[T]:
        """Wrap an iterable of a known length."""


def silent(iterable: Iterable[T], _description: str, _total: int, /) -> Iterable[T]:
    """Show no progress."""
    return iterable


class Run(Protocol):
    """Computes a function of each item, in order; possibly in other processes."""

    def __call__(self, function: Callable[[A], T], items: Sequence[A], /) -> Iterator[T]:
        """Yield the results."""


def run_here(function: Callable[[A], T], items: Sequence[A], /) -> Iterator[T]:
    """Compute in this process: the `Run` of a short script or a notebook."""
    return map(function, items)


@contextmanager
def tasks_run(jobs: int) -> Iterator[Run]:
    """Start worker processes, or none if `jobs` is 0, and yield what runs tasks in them."""
    if jobs == 0:
        yield run_here
        return
    with Pool(jobs, time_limit=None) as pool:
        yield lambda function, items: _results(pool.map(function, items))


def _results(tasks: Iterable[PoolTask[T]]) -> Iterator[T]:
    for task in tasks:
        try:
            yield task.result()
        except CrashError as error:
            raise ModelError(
                f"the training has ended, since a process that described a shape did ({error}); use fewer "
                "jobs if memory was short"
            ) from error
