# SPDX-License-Identifier: MIT
"""How processes are started that work side by side: numerical libraries on one thread each, no windows."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["NO_WINDOW", "THREAD_VARIABLES", "divert_output", "single_threaded", "without_memory_limit"]

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
