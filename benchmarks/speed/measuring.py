# SPDX-License-Identifier: MIT
"""What every section is asked and answers, and timing alternatives against each other."""

from __future__ import annotations

import gc
import importlib.util
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

__all__ = ["Contestant", "Options", "Row", "installed", "race"]

Row = dict[str, Any]
"""Figures of one thing that was timed."""


@dataclass(frozen=True)
class Options:
    """What every section is asked.

    Attributes
    ----------
    sizes : tuple of int
        Numbers of vertices or of shapes, as the section says.
    repeats : int
        Times are medians of so many.
    folder : Path
        For files that are deleted again.
    library : Path or None
        A real one, for the recall of "search".
    """

    sizes: tuple[int, ...]
    repeats: int
    folder: Path
    library: Path | None = None


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


@dataclass
class _Times:
    wall: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)


def installed(*modules: str) -> bool:
    """Tell whether all these modules can be imported."""
    return all(importlib.util.find_spec(name) is not None for name in modules)


def race(task: str, size: int, contestants: Sequence[Contestant], repeats: int) -> list[Row]:
    """Time the contestants in turns, so that a busy minute of the machine falls on all of them.

    Parameters
    ----------
    task, size
        Go into the rows.
    contestants : sequence of Contestant
        The first is what the others are compared with.
    repeats : int
        Rounds. The medians are over them.

    Returns
    -------
    rows : list of Row
        In the order of the contestants. "seconds" and "cpu_seconds": processor time counts what this process
        used, whatever else ran. "ratio": processor time over that of the first contestant, above 1 is slower
        than it. "error": None where it is not measured.
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
        {
            "task": task,
            "size": size,
            "contestant": contestant.name,
            "seconds": round(median(each.wall), 4),
            "cpu_seconds": round(median(each.processor), 4),
            "ratio": round(median(each.processor) / base, 3),
            "error": error,
        }
        for contestant, each, error in zip(contestants, times, errors, strict=True)
    ]
