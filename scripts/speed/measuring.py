# SPDX-License-Identifier: MIT
"""Time alternatives against each other."""

from __future__ import annotations

import gc
import importlib.util
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Any

__all__ = ["Contestant", "Options", "Row", "installed", "race"]


@dataclass(frozen=True)
class Options:
    """What every section is asked."""

    sizes: tuple[int, ...]
    repeats: int


@dataclass(frozen=True)
class Contestant:
    """A way to do a task.

    Attributes
    ----------
    name : str
    run : callable
        Does it, all of what is timed.
    error : callable, optional
        What its result deviates from the truth by.
    """

    name: str
    run: Callable[[], Any]
    error: Callable[[Any], float] | None = None


@dataclass(frozen=True)
class Row:
    """How one contestant did at one task.

    Attributes
    ----------
    section, task : str
    size : int
        What the task grows with, such as the number of vertices.
    contestant : str
    seconds, cpu_seconds : float
        Medians over the repeats. Processor time counts what this process used, whatever else ran.
    ratio : float
        Processor time over that of the first contestant: above 1 is slower than it.
    error : float or None
        Deviation from the reference, as the section defines it.
    """

    section: str
    task: str
    size: int
    contestant: str
    seconds: float
    cpu_seconds: float
    ratio: float
    error: float | None = None


@dataclass
class _Times:
    wall: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)


def installed(*modules: str) -> bool:
    """Tell whether all these modules can be imported."""
    return all(importlib.util.find_spec(name) is not None for name in modules)


def race(
    section: str,
    task: str,
    size: int,
    contestants: Sequence[Contestant],
    repeats: int,
) -> list[Row]:
    """Time the contestants in turns, so that a busy minute of the machine falls on all of them.

    Parameters
    ----------
    section, task, size
        Go into the rows.
    contestants : sequence of Contestant
        The first is what the others are compared with.
    repeats : int
        Rounds. The medians are over them.

    Returns
    -------
    rows : list of Row
        In the order of the contestants.
    """
    times = [_Times() for _ in contestants]
    errors: list[float | None] = [None] * len(contestants)
    for _ in range(repeats):
        for index, contestant in enumerate(contestants):
            gc.collect()
            wall, processor = time.perf_counter(), time.process_time()
            result = contestant.run()
            times[index].processor.append(time.process_time() - processor)
            times[index].wall.append(time.perf_counter() - wall)
            if contestant.error is not None:
                errors[index] = contestant.error(result)
            del result
    base = median(times[0].processor)
    return [
        Row(
            section,
            task,
            size,
            contestant.name,
            median(each.wall),
            median(each.processor),
            median(each.processor) / base,
            deviation,
        )
        for contestant, each, deviation in zip(contestants, times, errors, strict=True)
    ]
