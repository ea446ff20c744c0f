# SPDX-License-Identifier: MIT
"""Progress of `shapegoogle index` on stderr: a bar on a terminal, an occasional line in a log."""

from __future__ import annotations

import json
import sys
import time
from typing import Self

from tqdm import tqdm

from shapegoogle_core.indexing import FileOutcome
from shapegoogle_core.processes.progress import SECONDS_BETWEEN_LINES

__all__ = ["IndexProgress"]


class IndexProgress:
    """Shows the progress of `index_files`, and each failed file when it fails.

    Use it as a context manager and give it to `index_files` as `progress`.

    Parameters
    ----------
    total : int
        Number of files.
    verbose : bool
        Also show the traceback of unexpected errors.
    events : bool
        Also print one line of JSON for each file on stdout, for a program that shows the progress:
        ``{"done": 3, "total": 8, "path": …, "status": "added", "reason": ""}``.

    Attributes
    ----------
    done : int
        Number of files counted so far.
    """

    def __init__(self, total: int, *, verbose: bool = False, events: bool = False) -> None:
        self.done = 0
        self._events = events
        self._failed = 0
        self._total = total
        self._verbose = verbose
        self._started = self._last_line = time.monotonic()
        self._bar = tqdm(total=total, unit="file", disable=not sys.stderr.isatty(), dynamic_ncols=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def __call__(self, outcome: FileOutcome) -> None:
        """Count a file."""
        self.done += 1
        if self._events:
            event = {
                "done": self.done,
                "total": self._total,
                "path": str(outcome.path),
                "status": outcome.status,
                "reason": outcome.reason,
            }
            print(json.dumps(event), flush=True)
        if outcome.status == "failed":
            self._failed += 1
            self._bar.set_postfix(failed=self._failed)
            self._write(f"skipped {outcome.path}: {outcome.reason}")
            if self._verbose and outcome.details:
                self._write(outcome.details)
        self._bar.update()
        now = time.monotonic()
        if self._bar.disable and now - self._last_line >= SECONDS_BETWEEN_LINES:
            self._last_line = now
            rate = self.done / (now - self._started)
            self._write(f"{self.done} of {self._total} files, {rate:.1f} per second, {self._failed} failed")

    def _write(self, text: str) -> None:
        with self._bar.external_write_mode(file=sys.stderr):
            print(text, file=sys.stderr, flush=True)
