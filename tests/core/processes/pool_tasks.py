# SPDX-License-Identifier: MIT
"""Tasks for the tests of the pool, importable by its processes."""

from __future__ import annotations

import os
import signal
import tempfile
import time
from pathlib import Path
from typing import BinaryIO

import numpy as np

from shapegoogle_core.processes import worker


def misbehave(what: str) -> str:
    """Do what the word says; other words are returned."""
    match what:
        case "wait":
            time.sleep(1.5)
        case "hang":
            time.sleep(3600)
        case "abort":
            os.abort()
        case "exit":
            os._exit(3)
        case "swell":
            np.ones(2**31)
        case "raise":
            raise LookupError("an unexpected error")
        case "print":
            print("output of a library")
    return what


def where_temporary_files_go() -> str:
    return tempfile.gettempdir()


def prepare(log: Path) -> int:
    """Note that a process has started; returns its number."""
    with log.open("a") as file:
        file.write(f"{os.getpid()}\n")
    return os.getpid()


def add_to_start(started: int, number: int) -> tuple[bool, int]:
    """Return whether `prepare` ran in this process, and the number."""
    return started == os.getpid(), number


def refuse() -> None:
    """Fail to prepare a process."""
    raise ValueError("cannot be prepared")


def log_and_return(log: Path, word: str) -> str:
    with log.open("a") as file:
        file.write(f"{word}\n")
    return word


def wait_for(path: Path) -> None:
    """Wait until a file is there."""
    while not path.exists():
        time.sleep(0.01)


def die_while_answering() -> None:
    """Make this process die when it has sent a part of its answer."""

    def send_a_part(pipe: BinaryIO, content: bytes) -> None:
        pipe.write((len(content) + 1000).to_bytes(8, "little") + content)
        os.kill(os.getpid(), signal.SIGKILL)

    setattr(worker, "write_frame", send_a_part)  # noqa: B010 - it is no variable
