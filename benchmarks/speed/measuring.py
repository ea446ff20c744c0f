# SPDX-License-Identifier: MIT
"""Options and rows of all sections, and timing of alternatives."""

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
"""Figures of one measurement."""


@dataclass(frozen=True)
class Options:
    """Options of a section.

    Attributes
    ----------
    sizes : tuple of int
        Numbers of vertices or of shapes, as the section says.
    repeats : int
        Repetitions of which the median is taken.
    folder : Path
        For temporary files.
    library : Path or None
        A real library, for the recall of "search".
    keep : Path or None
        For the libraries of "kinds", which the next run uses again.
    """

    sizes: tuple[int, ...]
    repeats: int
    folder: Path
    library: Path | None = None
    keep: Path | None = None


@dataclass(frozen=True)
class Contestant:
    """An alternative that is timed.

    Attributes
    ----------
    name : str
    run : callable
        Does the task; all of it is timed.
    error : callable, optional
        Computes the deviation of its result from the truth.
    """

    name: str
    run: Callable[[], Any]
    error: Callable[[Any], float] | None = None


@dataclass
class _Times:
    wall: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)


def installed(*modules: str) -> bool:
    """Return whether all these modules can be imported."""
    return all(importlib.util.find_spec(name) is not None for name in modules)


def race(task: str, size: int, contestants: Sequence[Contestant], repeats: int) -> list[Row]:
    """Time the contestants in turns, so that a busy minute of the machine falls on all of them.

    Parameters
    ----------
    task, size
        Copied into the rows.
    contestants : sequence of Contestant
        The others are compared with the first.
    repeats : int
        Rounds. The medians are over them.

    Returns
    -------
    rows : list of Row
        In the order of the contestants, with "seconds" (wall time) and "cpu_seconds" (processor time of this
        process), "ratio" (processor time over that of the first contestant; above 1 is slower) and "error"
        (None where it is not measured).
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
