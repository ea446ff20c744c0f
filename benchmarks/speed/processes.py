# SPDX-License-Identifier: MIT
"""Figures of running processes on Linux: memory, threads, parents."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

__all__ = ["ProcessFigures", "descendants", "figures_of"]


@dataclass(frozen=True)
class ProcessFigures:
    """Figures of a process at one moment.

    Attributes
    ----------
    parent : int
        Process id.
    memory_mb, peak_mb : float
        Memory now, and at most since its program began; unlike ``ru_maxrss`` without that of the process that
        started it.
    threads : int
    cpu_seconds : float
        Processor time so far, without its child processes.
    """

    parent: int
    memory_mb: float
    peak_mb: float
    threads: int
    cpu_seconds: float


def figures_of(process: int | None = None) -> ProcessFigures | None:
    """Read the figures of a process.

    Parameters
    ----------
    process : int, optional
        Process id; left out, this process.

    Returns
    -------
    figures : ProcessFigures or None
        None if it has ended, and where there is no ``/proc``.
    """
    try:
        folder = Path("/proc", str(process or os.getpid()))
        lines = (folder / "status").read_text().splitlines()
        # Behind the program's name, which may have spaces and brackets.
        user_ticks, system_ticks = (folder / "stat").read_text().rpartition(")")[2].split()[11:13]
    except OSError:
        return None
    values = dict(line.split(":", 1) for line in lines if ":" in line)
    if "VmHWM" not in values:  # ended, but not yet waited for
        return None
    return ProcessFigures(
        parent=int(values["PPid"]),
        memory_mb=int(values["VmRSS"].split()[0]) / 1024,
        peak_mb=int(values["VmHWM"].split()[0]) / 1024,
        threads=int(values["Threads"]),
        cpu_seconds=(int(user_ticks) + int(system_ticks)) / os.sysconf("SC_CLK_TCK"),
    )


def descendants(process: int) -> dict[int, ProcessFigures]:
    """Read the figures of a process and its descendants.

    Parameters
    ----------
    process : int
        Process id.

    Returns
    -------
    figures : dict of int to ProcessFigures
        By process id; empty where there is no ``/proc``.
    """
    known = {}
    for entry in Path("/proc").glob("[0-9]*"):
        figures = figures_of(int(entry.name))
        if figures is not None:
            known[int(entry.name)] = figures
    found: dict[int, ProcessFigures] = {}
    waiting = [process]
    while waiting:
        parent = waiting.pop()
        if parent in known:
            found[parent] = known[parent]
            waiting += [child for child, figures in known.items() if figures.parent == parent]
    return found
