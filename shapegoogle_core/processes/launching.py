# SPDX-License-Identifier: MIT
"""How processes are started that work side by side: numerical libraries on one thread each, no windows."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = [
    "NO_WINDOW",
    "THREAD_VARIABLES",
    "divert_output",
    "orderly_end",
    "single_threaded",
    "without_memory_limit",
]

THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Environment variables that the libraries read when they are imported."""

NO_WINDOW: int = getattr(subprocess, "CREATE_NO_WINDOW", 0)
"""Flag for `subprocess.Popen`: on Windows a console would open beside a program with a window."""


@contextmanager
def single_threaded() -> Iterator[None]:
    """Have processes started inside the block compute on one thread each, unless the user chose a number.

    The variables must be there before numpy is imported, which is before a worker's first own line runs.
    """
    added = [name for name in THREAD_VARIABLES if name not in os.environ]
    os.environ.update(dict.fromkeys(added, "1"))
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)


def divert_output() -> int:
    """Have what libraries print, from C too, appear on standard error; nowhere if there is none.

    Returns
    -------
    output : int
        File descriptor of what was standard output.
    """
    for standard in (1, 2):
        try:
            os.fstat(standard)
        except OSError:
            # A program without a console need not have them; the next file opened must not take their place.
            nowhere = os.open(os.devnull, os.O_WRONLY)
            if nowhere != standard:
                os.dup2(nowhere, standard)
                os.close(nowhere)
    output = os.dup(1)
    os.dup2(2, 1)
    return output


@contextmanager
def without_memory_limit() -> Iterator[None]:
    """Have processes started inside the block not inherit this process's limit of memory (Linux)."""
    if sys.platform != "linux":
        yield
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@contextmanager
def orderly_end() -> Iterator[None]:
    """Have SIGTERM, with which a program ends another, act as Ctrl-C does: what is temporary is removed.

    Windows has no such signal: a process that is ended there removes nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        # Only the main thread gets signals and may say what they do.
        yield
        return

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        # Asked once more, it is still tidying up.
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL if previous is None else previous)
