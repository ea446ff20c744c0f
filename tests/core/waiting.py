# SPDX-License-Identifier: MIT
"""Waiting for other processes, and interrupting them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import pytest

from shapegoogle_core.library.library import Library


def wait_for_sources(library: Library, wanted: int, process: subprocess.Popen[str]) -> None:
    """Wait until the running command has stored so many files."""
    while len(library.sources()) < wanted:
        assert process.poll() is None, "the command ended too early"
        time.sleep(0.05)


def wait_until_gone(group: int) -> None:
    """Wait until no process is left in a group; a worker that never ends lets this test hang, not pass."""
    while True:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Let processes receive Ctrl-C and the end of the terminal.

    Shells start background jobs with the first ignored, nohup with the second, and programs inherit that.
    """
    handlers: dict[signal.Signals, Any] = {signal.SIGINT: signal.default_int_handler}
    if sys.platform != "win32":
        handlers[signal.SIGHUP] = signal.SIG_DFL
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
