# SPDX-License-Identifier: MIT
"""How processes are started that work side by side: numerical libraries on one thread each, no windows."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["NO_WINDOW", "THREAD_VARIABLES", "single_threaded"]

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
