# SPDX-License-Identifier: MIT
"""Starting the command in another process."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from typing import Protocol

Command = Callable[..., tuple[int, str, str]]
"""Runs the command in this process: exit code, stdout, stderr."""


class Shapegoogle(Protocol):
    """Runs the command to its end."""

    def __call__(self, *arguments: object) -> subprocess.CompletedProcess[str]: ...


class StartShapegoogle(Protocol):
    """Starts the command."""

    def __call__(self, *arguments: object) -> subprocess.Popen[str]: ...


def command_line(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "shapegoogle_core", *map(str, arguments)]


def start(*arguments: object) -> subprocess.Popen[str]:
    """Start the command in a process group of its own, as a terminal does."""
    return subprocess.Popen(
        command_line(*arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env=os.environ | {"OMP_NUM_THREADS": "1", "PYTHONIOENCODING": "utf-8"},
        start_new_session=True,
    )


def without_progress(stderr: str) -> str:
    """Drop the lines of progress, which a slow machine prints and a fast one does not."""
    return re.sub(r"^[\d,]+ of [\d,]+ files?,.* \d+ failed\n", "", stderr, flags=re.MULTILINE)
