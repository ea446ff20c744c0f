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
import weakref
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


# Programs that this process has launched.
_launched: weakref.WeakSet[subprocess.Popen[bytes]] = weakref.WeakSet()


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
    _launched.add(process)
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
    """Make SIGTERM, and closing the terminal, act as Ctrl-C does inside the block, so that it can clean up.

    Windows has no such signals: a process that is terminated there removes nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        # Only the main thread receives signals and may handle them.
        yield
        return

    numbers = [signal.SIGTERM]
    # `nohup` ignores the signal of a closed terminal, and so it stays.
    if sys.platform != "win32" and signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
        numbers.append(signal.SIGHUP)

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        # A second signal must not interrupt the cleaning up.
        for number in numbers:
            signal.signal(number, signal.SIG_IGN)
        raise KeyboardInterrupt

    previous = {number: signal.signal(number, interrupt) for number in numbers}
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Keep Ctrl-C, and the closing of a terminal, from processes started inside the block.

    They inherit the blocked signals, and so do the threads that start their successors. Without it, a worker
    that is still importing prints a traceback, and one that works seems to have crashed. The signals
    themselves arrive after the block.
    """
    if sys.platform == "win32":
        yield
        return
    with _handled_later(), _signals_blocked():
        yield


@contextmanager
def _handled_later() -> Iterator[None]:
    """Keep Python's own handlers of signals that end a program waiting until the end of the block.

    Another thread may receive a signal that this one blocks, and Python then calls its handler in the main
    thread all the same: a process that is just started would wait for the rest of what it is told, in vain.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    handlers = {number: handler for number in numbers if callable(handler := signal.getsignal(number))}
    received: list[int] = []
    for number in handlers:
        signal.signal(number, lambda number, _frame: received.append(number))
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for signal_number in dict.fromkeys(received):
            signal.raise_signal(signal_number)


@contextmanager
def _signals_blocked() -> Iterator[None]:
    # This helper of multiprocessing ignores only Ctrl-C by itself, and starting it unblocks that again, so it
    # must run already.
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGHUP})
    resource_tracker.ensure_running()
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
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
    """End this process of `multiprocessing` when its parent has gone or asks it to, and what it has launched.

    Nobody else would stop a program that hangs.
    """

    def watch() -> None:
        parent = multiprocessing.parent_process()
        if parent is not None:
            parent.join()
            _kill_launched()
            os._exit(1)

    def end(number: int, _frame: FrameType | None) -> None:
        _kill_launched()
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)

    signal.signal(signal.SIGTERM, end)
    threading.Thread(target=watch, daemon=True).start()


def _kill_launched() -> None:
    for process in tuple(_launched):
        process.kill()


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
