# SPDX-License-Identifier: MIT
"""Whether another process works: a busy machine may take minutes for a second of its work."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

__all__ = ["Silence", "Standstill", "processor_seconds"]

# Seconds of processor time that count as a sign of life: what waits for ever looks at a clock now and then.
LEAST_WORK = 0.2
PROC = Path("/proc")
# How many times as long as on an idle machine a process may take on a busy one.
MOST_TIMES = 5.0


class Silence:
    """Notices when a process has shown no sign of life for a while: it neither worked nor printed.

    Parameters
    ----------
    pid : int
    patience : float
        Seconds.
    clock, work : callable, optional
        For tests.
    """

    def __init__(
        self,
        pid: int,
        patience: float,
        clock: Callable[[], float] = time.monotonic,
        work: Callable[[int], float | None] | None = None,
    ) -> None:
        self._pid = pid
        self._patience = patience
        self._clock = clock
        self._work_of = work or processor_seconds
        self._since = clock()
        self._work = 0.0
        self._printed = 0

    def is_over(self, printed: int) -> bool:
        """Look at the process.

        Parameters
        ----------
        printed : int
            Number of lines that it has printed so far.

        Returns
        -------
        over : bool
            Whether the patience is exhausted.
        """
        now, work = self._clock(), self._work_of(self._pid)
        if printed > self._printed or (work is not None and work >= self._work + LEAST_WORK):
            self._since, self._printed, self._work = now, printed, work or 0.0
        return now - self._since > self._patience


class Standstill:
    """Notices when a process has had its time: on a busy machine it gets less of a second than a second.

    Parameters
    ----------
    pid : int
    limit : float
        Seconds. As long as the process shows signs of life, but has not worked for so long, it gets up to
        `MOST_TIMES` as many.
    clock, work : callable, optional
        For tests.
    """

    def __init__(
        self,
        pid: int,
        limit: float,
        clock: Callable[[], float] = time.monotonic,
        work: Callable[[int], float | None] | None = None,
    ) -> None:
        self._pid = pid
        self._limit = limit
        self._clock = clock
        self._work = work or processor_seconds
        self._silence = Silence(pid, limit, clock, self._work)
        self._begun = clock()
        self._work_before = self._work(pid)

    def is_over(self, printed: int) -> bool:
        """Look at the process.

        Parameters
        ----------
        printed : int
            Number of lines that it has printed so far.

        Returns
        -------
        over : bool
            Whether the time is up.
        """
        is_silent = self._silence.is_over(printed)
        seconds, work = self._clock() - self._begun, self._work(self._pid)
        if seconds <= self._limit:
            return False
        if work is None or self._work_before is None or is_silent:
            return True
        return work - self._work_before >= self._limit or seconds > MOST_TIMES * self._limit


def processor_seconds(pid: int) -> float | None:
    """Processor time that a process and those that it has started have used.

    Parameters
    ----------
    pid : int

    Returns
    -------
    seconds : float or None
        None where that is not known: outside Linux, or if the process has ended.

    Examples
    --------
    >>> import os, sys
    >>> from shapegoogle_core.processes.signs_of_life import processor_seconds
    >>> sys.platform != "linux" or processor_seconds(os.getpid()) > 0
    True
    """
    if sys.platform != "linux":
        return None
    try:
        # The name of the program, in parentheses, may contain blanks.
        fields = (PROC / f"{pid}/stat").read_text(errors="replace").rpartition(")")[2].split()
        children = (PROC / f"{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return None
    # Of itself in user and system mode, and of its children that have ended.
    ticks = sum(map(int, fields[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK") + sum(processor_seconds(int(child)) or 0.0 for child in children)
