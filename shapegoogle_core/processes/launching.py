# SPDX-License-Identifier: MIT
"""Starting processes and ending them in an orderly way.

Processes that work side by side compute on one thread each, open no windows, do not outlive their parent and
clean up when they are interrupted.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from multiprocessing import resource_tracker
from pathlib import Path
from types import FrameType
from typing import BinaryIO

from shapegoogle_core.processes.messages import MESSAGES, inheritable

__all__ = [
    "NO_WINDOW",
    "block_broken_pipe_signal",
    "cause_of_death",
    "default_jobs",
    "divert_output",
    "end_with_parent",
    "interrupts_blocked",
    "launch",
    "limit_memory",
    "orderly_end",
    "single_threaded",
    "without_memory_limit",
]

THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""Environment variables that the libraries read when they are imported."""

NO_WINDOW: int = getattr(subprocess, "CREATE_NO_WINDOW", 0)
"""Flag for `subprocess.Popen`: on Windows a console would open beside a program with a window."""


def default_jobs() -> int:
    """Return the number of processors this process may use.

    Returns
    -------
    jobs : int
    """
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def launch(
    command: Sequence[str],
    *,
    environment: Mapping[str, str] | None = None,
    with_input: bool = True,
    with_output: bool = True,
) -> tuple[subprocess.Popen[bytes], BinaryIO]:
    """Start another program with pipes to it, and without a window of its own.

    The program does not inherit this process's memory limit: Blender, for one, reserves far more memory than
    it uses.

    Parameters
    ----------
    command : sequence of str
        The program and its arguments.
    environment : mapping of str to str, optional
        All its environment variables; by default those of this process.
    with_input : bool, optional
        Whether its standard input is a pipe; it is empty otherwise.
    with_output : bool, optional
        Whether its standard output is a pipe that standard error goes to as well, to be read all the time;
        both are those of this process otherwise.

    Returns
    -------
    process : subprocess.Popen
    messages : binary file
        What it writes to its message pipe, see `messages`.

    Raises
    ------
    OSError
        If the program cannot be started.
    """
    reading, writing = os.pipe()
    messages = os.fdopen(reading, "rb")
    try:
        with without_memory_limit(), inheritable(writing) as (number, options):
            process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE if with_input else subprocess.DEVNULL,
                stdout=subprocess.PIPE if with_output else None,
                stderr=subprocess.STDOUT if with_output else None,
                creationflags=NO_WINDOW,
                env={**(os.environ if environment is None else environment), MESSAGES: number},
                **options,
            )
    except BaseException:
        messages.close()
        raise
    finally:
        # As long as it is open here too, the end of the program is not the end of its messages.
        os.close(writing)
    return process, messages


@contextmanager
def single_threaded() -> Iterator[None]:
    """Make processes started inside the block compute on one thread each, unless the user chose a number.

    The variables must be set before numpy is imported, that is before the first line of a worker's own code.
    """
    added = [name for name in THREAD_VARIABLES if name not in os.environ]
    os.environ.update(dict.fromkeys(added, "1"))
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)


def divert_output() -> int:
    """Send everything that libraries print, from C too, to standard error, or nowhere if there is none.

    Returns
    -------
    output : int
        File descriptor of the former standard output.
    """
    for standard in (1, 2):
        try:
            os.fstat(standard)
        except OSError:
            # A program without a console may lack them; the next opened file must not take their place.
            nowhere = os.open(os.devnull, os.O_WRONLY)
            if nowhere != standard:
                os.dup2(nowhere, standard)
                os.close(nowhere)
    output = os.dup(1)
    os.dup2(2, 1)
    return output


@contextmanager
def without_memory_limit() -> Iterator[None]:
    """Keep processes started inside the block from inheriting this process's memory limit (Linux)."""
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
    """Make SIGTERM act as Ctrl-C does inside the block, so that temporary files are removed.

    Windows has no such signal: a process that is terminated there removes nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        # Only the main thread receives signals and may handle them.
        yield
        return

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        # A second signal must not interrupt the cleaning up.
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL if previous is None else previous)


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Keep Ctrl-C, which reaches all processes of a terminal, from those started inside the block.

    They inherit the blocked signal, and so do the threads that start their successors. Without it, a worker
    that is still importing prints a traceback. The signal itself arrives after the block.
    """
    if sys.platform == "win32":
        yield
        return
    # Starting this helper of multiprocessing unblocks the signal again, so it must run already.
    resource_tracker.ensure_running()
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)


def block_broken_pipe_signal() -> None:
    """Have writes of this thread to a program that has ended raise BrokenPipeError, as Python usually does.

    Python ignores SIGPIPE, but not inside Blender: there the signal would end Blender.
    """
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})


def end_with_parent() -> None:
    """End this process of `multiprocessing` when its parent has gone, possibly killed.

    Nobody else would stop it if it hangs.
    """

    def watch() -> None:
        parent = multiprocessing.parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def limit_memory(megabytes: int) -> None:
    """Limit the memory that this process may allocate from now on, and write no core file in a crash (Linux).

    Parameters
    ----------
    megabytes : int
        On top of the memory that it holds already.
    """
    if sys.platform != "linux":
        return
    import resource

    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + megabytes * 2**20
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    if hard == resource.RLIM_INFINITY or limit < hard:
        resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def cause_of_death(exit_code: int) -> str:
    """Describe how a process ended, for a message.

    Parameters
    ----------
    exit_code : int
        Negative for a signal.

    Returns
    -------
    cause : str
        Such as "exit code 3" or "SIGSEGV".
    """
    if exit_code >= 0 or sys.platform == "win32":
        return f"exit code {exit_code}"
    name = signal.Signals(-exit_code).name if -exit_code in set(signal.Signals) else f"signal {-exit_code}"
    if name == "SIGKILL":
        return f"{name}: the system ended it, as it does when memory runs out"
    return name
