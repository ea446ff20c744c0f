# SPDX-License-Identifier: MIT
"""Running a function for many items in worker processes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from shapegoogle_core.processes.pool import Pool
from shapegoogle_core.processes.progress import progress_bar

__all__ = ["TIME_LIMIT", "map_in_processes"]

T = TypeVar("T")
R = TypeVar("R")

TIME_LIMIT = 3600.0
"""Seconds for one item: an hour, since measurements also run at low priority beside other programs."""


def map_in_processes(function: Callable[[T], R], items: Sequence[T], jobs: int, title: str) -> list[R]:
    """Call a function for each item in worker processes, with one thread each.

    Parameters
    ----------
    function : callable
        Importable by its name, or a partial of such a function.
    items : sequence
    jobs : int
        Number of processes.
    title : str
        Description in the progress bar.

    Returns
    -------
    results : list
        In the order of the items.

    Raises
    ------
    TimeLimitError, CrashError
        If an item takes longer than `TIME_LIMIT`, or ends its process.
    Exception
        Any exception of the function.
    """
    with Pool(jobs, TIME_LIMIT) as pool:
        return [task.result() for task in progress_bar(pool.map(function, items), title, len(items))]
