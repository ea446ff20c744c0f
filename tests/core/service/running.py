# SPDX-License-Identifier: MIT
"""`shapegoogle serve` as a user starts it, in a process of its own."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Running:
    """A service that runs.

    Attributes
    ----------
    process : subprocess.Popen
        Of the command; with several workers, the parent of theirs.
    address : str
        Such as "http://127.0.0.1:12345/".
    """

    process: subprocess.Popen[str]
    address: str

    def get(self, path: str) -> Any:
        """Return the JSON at an address of the service."""
        with urllib.request.urlopen(f"{self.address}api/{path}", timeout=60) as answer:
            return json.load(answer)

    def post(self, path: str, content: object) -> Any:
        """Send JSON, and return the JSON of the answer."""
        request = urllib.request.Request(
            f"{self.address}api/{path}", json.dumps(content).encode(), {"Content-Type": "application/json"}
        )
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)


@contextmanager
def running_service(library: Path, *options: str) -> Iterator[Running]:
    """Start a service at any free port, and end it after the block."""
    command = [sys.executable, "-m", "shapegoogle_core", "serve", "--library", str(library), "--port", "0"]
    process = subprocess.Popen([*command, *options], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        found = re.search(r"http://\S+", process.stdout.readline())
        assert found is not None, f"the service ended with exit code {process.wait()}"
        running = Running(process, found[0])
        while process.poll() is None:
            try:
                assert running.get("health") == {"status": "ok"}
                break
            except OSError:
                time.sleep(0.1)
        yield running
    finally:
        process.terminate()
        process.wait()
